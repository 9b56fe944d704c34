"""The Python LOP upsamples the stage of its node by the asset's parameters; `hou` is a stand-in."""

import sys
import types
from pathlib import Path

import pytest
from pxr import Sdf, Usd
from rigs import ANIMATION, make_rig

from geomstats_anim.names import SCHEME_NAMES

FOLDER = Path(__file__).resolve().parents[2] / "integrations" / "houdini"


class NodeError(Exception):
    """As in hou."""


class NodeWarning(Exception):
    """As in hou."""


class Node:
    """A node of Solaris, as far as the script uses nodes."""

    def __init__(self, parent=None, kind=None, stage=None, **parameters):
        self.above, self.kind, self.stage, self.parameters = parent, kind, stage, parameters
        self.children, self.inputs, self.asset = {}, {}, None

    def parent(self):
        return self.above

    def evalParm(self, name):  # noqa: N802
        return self.parameters[name]

    def editableStage(self):  # noqa: N802
        return self.stage

    def createNode(self, kind, name):  # noqa: N802
        return self.children.setdefault(name, Node(self, kind))

    def node(self, name):
        return self.children.get(name)

    def parm(self, name):
        return types.SimpleNamespace(set=lambda value: self.parameters.update({name: value}))

    def setInput(self, index, node):  # noqa: N802
        self.inputs[index] = node

    def indirectInputs(self):  # noqa: N802
        return ["first input"]

    def createDigitalAsset(self, name, hda_file_name, description, min_num_inputs, max_num_inputs):  # noqa: N802
        self.asset = {"name": name, "file": hda_file_name, "inputs": (min_num_inputs, max_num_inputs)}
        return self

    def type(self):
        keep = types.SimpleNamespace(setParmTemplateGroup=lambda group: self.asset.update(parameters=group))
        return types.SimpleNamespace(definition=lambda: keep)


@pytest.fixture
def solaris(monkeypatch):
    """The node /stage; and the module under test as `lop`."""
    stage = Node()

    def template(name, label, n_components, **options):
        return name, options

    hou = types.SimpleNamespace(
        NodeError=NodeError,
        NodeWarning=NodeWarning,
        node={"/stage": stage}.get,
        ParmTemplateGroup=dict,
        IntParmTemplate=template,
        StringParmTemplate=template,
    )
    monkeypatch.setitem(sys.modules, "hou", hou)
    monkeypatch.syspath_prepend(str(FOLDER))
    monkeypatch.delitem(sys.modules, "geodesic_lop", raising=False)
    import geodesic_lop

    stage.lop = geodesic_lop
    return stage


def lop(stage, factor=2, scheme="as stored", styles="", prims=""):
    """Return the Python LOP of an asset with these parameters, on a stage whose layer is Houdini's."""
    layer = Sdf.Layer.CreateAnonymous("LOP.usda")
    stage.GetRootLayer().subLayerPaths.insert(0, layer.identifier)
    stage.GetRootLayer().SetPermissionToSave(False)
    stage.SetEditTarget(stage.GetEditTargetForLocalLayer(layer))
    node = Node(Node(factor=factor, scheme=scheme, styles=styles, prims=prims), stage=stage)
    node.layer = layer
    return node


def input_stage(tmp_path):
    make_rig(tmp_path / "in.usda")
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths = [str(tmp_path / "in.usda")]
    return stage


def test_it_upsamples_into_the_layer_of_the_node(tmp_path, solaris):
    node = lop(input_stage(tmp_path), 3, "geodesic", "arm:alpha=4 spine:beta=.5", "/Rig/Skel")
    solaris.lop.cook(node)
    prim = node.stage.GetPrimAtPath(ANIMATION)
    assert len(prim.GetAttribute("rotations").GetTimeSamples()) == 10
    assert node.layer.GetPrimAtPath(ANIMATION).attributes["geodesicMetric:scheme"].default == "geodesic"
    assert prim.GetAttribute("geodesicMetric:beta").Get() == [1.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"styles": "leg:alpha=4"}, "leg matches no joint"),
        ({"prims": "/None"}, "there is no such prim"),
        ({"factor": 0}, "--factor"),
    ],
)
def test_what_is_refused_is_an_error_of_the_node(tmp_path, solaris, parameters, words):
    node = lop(input_stage(tmp_path), **parameters)
    with pytest.raises(NodeError, match=words):
        solaris.lop.cook(node)
    assert not node.layer.rootPrims


def test_a_locked_layer_is_an_error_of_the_node(tmp_path, solaris):
    node = lop(input_stage(tmp_path))
    node.layer.SetPermissionToEdit(False)
    with pytest.raises(NodeError, match="may not be edited; choose another edit target, or unlock it"):
        solaris.lop.cook(node)


def test_warnings_come_after_the_work(tmp_path, solaris):
    turns = [[(0.0, 0.0, 0.0, 1.0)] * 3, [(0.0, 0.0, 0.99, 0.14)] * 3]
    make_rig(tmp_path / "in.usda", codes=(0, 1), rotations=turns)
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().subLayerPaths = [str(tmp_path / "in.usda")]
    node = lop(stage)
    with pytest.raises(NodeWarning, match="degrees"):
        solaris.lop.cook(node)
    assert len(stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples()) == 3


def test_the_asset_is_made_from_text(tmp_path, solaris):
    solaris.lop.build(str(tmp_path / "geodesic.hda"))
    asset = solaris.children["geodesic"]
    inner, output = asset.children["upsample"], asset.children["output0"]
    assert (asset.kind, inner.kind, output.kind) == ("subnet", "pythonscript", "output")
    assert inner.inputs == {0: "first input"} and output.inputs == {0: inner}
    assert asset.asset["file"] == str(tmp_path / "geodesic.hda") and asset.asset["inputs"] == (1, 1)
    assert list(asset.asset["parameters"]) == ["factor", "scheme", "styles", "prims"]
    assert asset.asset["parameters"]["scheme"]["menu_items"] == ["as stored", *SCHEME_NAMES]
    called = []
    cook = types.SimpleNamespace(cook=called.append)
    sys.modules["hou"].pwd = lambda: inner
    code = inner.parameters["python"].replace("import geodesic_lop\n", "")
    exec(compile(code, "python", "exec"), {"geodesic_lop": cook, "hou": sys.modules["hou"]})
    assert called == [inner]
