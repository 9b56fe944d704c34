"""Python LOP for Houdini Solaris: in-betweens of the input's animations, in the node's layer.

It was not run in Houdini, but against a stand-in for `hou`, and over functions that are tested on open stages. Have
`geomstats-anim` in hython, put this folder on PYTHONPATH, and make the asset, whose source is this text:
`hython -c "import geodesic_lop; geodesic_lop.build('geodesic.hda')"`.
"""

from __future__ import annotations

from typing import Any

import hou

from geomstats_anim.names import SCHEME_NAMES
from usd_tools.console.errors import ToolError
from usd_tools.upsample import UpsampleOptions, upsample_stage

AS_STORED = "as stored"


def cook(node: Any) -> None:
    """Upsample the stage of the Python LOP inside the asset, by the parameters of the asset.

    Raises
    ------
    hou.NodeError
        If it is refused: what is wrong, a sentence.
    hou.NodeWarning
        After the work, if there are warnings.
    """
    asset, scheme = node.parent(), node.parent().evalParm("scheme")
    try:
        options = UpsampleOptions(
            factor=asset.evalParm("factor"),
            scheme=None if scheme == AS_STORED else scheme,
            joint=tuple(asset.evalParm("styles").split()),
            prim=tuple(asset.evalParm("prims").split()),
        )
        result = upsample_stage(node.editableStage(), options)
    except ToolError as error:
        raise hou.NodeError(str(error)) from error
    if result.warnings:
        raise hou.NodeWarning("\n".join(result.warnings))


def build(path: str) -> None:
    """Write the asset: a subnet with a Python LOP that calls `cook`, and its parameters."""
    asset = hou.node("/stage").createNode("subnet", "geodesic")
    inner = asset.createNode("pythonscript", "upsample")
    inner.parm("python").set("import geodesic_lop\n\ngeodesic_lop.cook(hou.pwd())\n")
    inner.setInput(0, asset.indirectInputs()[0])
    (asset.node("output0") or asset.createNode("output", "output0")).setInput(0, inner)
    asset = asset.createDigitalAsset("geomstats_anim::geodesic", path, "Geodesic In-betweens", 1, 1)
    schemes = [AS_STORED, *SCHEME_NAMES]
    asset.type().definition().setParmTemplateGroup(
        hou.ParmTemplateGroup(
            [
                hou.IntParmTemplate("factor", "Parts of Each Gap", 1, default_value=(4,), min=1, min_is_strict=True),
                hou.StringParmTemplate("scheme", "Scheme", 1, default_value=(AS_STORED,), menu_items=schemes),
                hou.StringParmTemplate("styles", "Styles", 1, help="such as *Arm*:alpha=4,tension=.5"),
                hou.StringParmTemplate("prims", "Primitives", 1, help="animations, skeletons, or above; default: all"),
            ]
        )
    )
