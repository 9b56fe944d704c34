"""Shelf script for Maya USD: in-betweens of the selected prims, in the layer that is the edit target.

It was not run in Maya, but against stand-ins for its modules, and over functions that are tested on open stages. Have
`geomstats-anim` in mayapy, put this folder on PYTHONPATH, and give a shelf button the line
`import geodesic_shelf; geodesic_shelf.main()`.
"""

from __future__ import annotations

from typing import Any

import mayaUsd.lib
import mayaUsd.ufe
import ufe
from maya import cmds

from usd_tools.console.errors import ToolError
from usd_tools.upsample import UpsampleOptions, upsample_stage


def main() -> None:
    """Ask for options, and upsample the selection, as one step of undo."""
    prims = selected_prims()
    if not prims:
        cmds.warning("Select a SkelAnimation, a Skeleton or a prim above them.")
        return
    answer = ask("4")
    if answer is not None:
        upsample_selected(prims, answer)


def selected_prims() -> list[Any]:
    """Return the USD prims that are selected."""
    paths = (ufe.PathString.string(item.path()) for item in ufe.GlobalSelection.get())
    return [prim for prim in map(mayaUsd.ufe.ufePathToPrim, paths) if prim]


def ask(text: str) -> str | None:
    """Ask for the parts of each gap, and styles after it; None if the user thinks better of it."""
    message = "Parts of each gap, then styles if any, such as\n4 *Arm*:alpha=4,tension=.5"
    buttons = {"button": ["Upsample", "Cancel"], "defaultButton": "Upsample", "cancelButton": "Cancel"}
    pressed = cmds.promptDialog(title="Geodesic In-betweens", message=message, text=text, **buttons)
    return cmds.promptDialog(query=True, text=True) if pressed == "Upsample" else None


def upsample_selected(prims: list[Any], answer: str) -> None:
    """Upsample the animations of prims in their stages' edit targets, and say what happened."""
    stages: dict[Any, list[str]] = {}
    for prim in prims:
        stages.setdefault(prim.GetStage(), []).append(str(prim.GetPath()))
    factor, *styles = answer.split() or [""]
    for stage, paths in stages.items():
        try:
            options = UpsampleOptions(factor=factor, joint=tuple(styles), prim=tuple(paths))
            mayaUsd.lib.UsdUndoManager.trackLayerStates(stage.GetEditTarget().GetLayer())
            with mayaUsd.lib.UsdUndoBlock():
                result = upsample_stage(stage, options, warn=cmds.warning)
        except ToolError as error:
            cmds.warning(str(error))
        else:
            cmds.inViewMessage(message=f"{result.brief}, in {result.output}.", position="midCenter", fade=True)
