"""The shelf script does what it is asked for in the edit target, whatever that is; Maya's modules are stand-ins."""

import sys
import types
from contextlib import contextmanager
from pathlib import Path

import pytest
from pxr import Usd
from rigs import ANIMATION, SKELETON, make_rig

FOLDER = Path(__file__).resolve().parents[2] / "integrations" / "maya"


class Maya:
    """The part of Maya that the script sees: a selection, an answer, and where it may write; it remembers calls."""

    def __init__(self):
        self.prims, self.answer, self.warnings, self.messages, self.undo = {}, "2", [], [], []

    def promptDialog(self, query=False, text=None, **_):  # noqa: N802
        return self.answer if query else "Upsample" if self.answer is not None else "Cancel"

    def modules(self):
        @contextmanager
        def block():
            self.undo.append("open")
            yield
            self.undo.append("closed")

        items = [types.SimpleNamespace(path=lambda path=path: path) for path in self.prims]
        cmds = types.SimpleNamespace(
            warning=self.warnings.append,
            promptDialog=self.promptDialog,
            inViewMessage=lambda message, **_: self.messages.append(message),
        )
        lib = types.SimpleNamespace(
            UsdUndoManager=types.SimpleNamespace(trackLayerStates=lambda layer: self.undo.append(layer)),
            UsdUndoBlock=block,
        )
        return {
            "maya": types.SimpleNamespace(cmds=cmds),
            "maya.cmds": cmds,
            "mayaUsd": types.SimpleNamespace(lib=lib, ufe=types.SimpleNamespace(ufePathToPrim=self.prims.get)),
            "mayaUsd.lib": lib,
            "mayaUsd.ufe": None,
            "ufe": types.SimpleNamespace(
                PathString=types.SimpleNamespace(string=str), GlobalSelection=types.SimpleNamespace(get=lambda: items)
            ),
        }


@pytest.fixture
def press(monkeypatch):
    """Press the button, with a selection."""

    def call(*prims, answer="2"):
        maya = Maya()
        maya.prims = {f"|proxy,{prim.GetPath()}#{i}": prim for i, prim in enumerate(prims)}
        maya.answer = answer
        monkeypatch.syspath_prepend(str(FOLDER))
        modules = maya.modules()
        modules["mayaUsd.ufe"] = modules["mayaUsd"].ufe
        for name, module in modules.items():
            monkeypatch.setitem(sys.modules, name, module)
        monkeypatch.delitem(sys.modules, "geodesic_shelf", raising=False)
        import geodesic_shelf

        geodesic_shelf.main()
        return maya

    return call


def codes(stage):
    return stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples()


def test_in_the_session_layer_in_one_step_of_undo(tmp_path, press):
    stage = make_rig(tmp_path / "in.usda")
    stage.SetEditTarget(stage.GetSessionLayer())
    maya = press(stage.GetPrimAtPath(SKELETON), answer="2 arm:alpha=4 spine:beta=.5")
    assert codes(stage) == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0] and not stage.GetRootLayer().dirty
    assert maya.undo == [stage.GetSessionLayer(), "open", "closed"] and maya.warnings == []
    assert maya.messages == [f"4 -> 7 samples, in {stage.GetSessionLayer().GetDisplayName()}."]
    assert stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:alpha").Get() == [1.0, 1.0, 4.0]


def test_a_locked_layer_is_a_sentence(tmp_path, press):
    stage = make_rig(tmp_path / "in.usda")
    stage.GetRootLayer().SetPermissionToEdit(False)
    maya = press(stage.GetPrimAtPath(SKELETON))
    assert maya.warnings == ["The edit target in.usda may not be edited; choose another edit target, or unlock it."]
    assert codes(stage) == [0.0, 1.0, 2.0, 3.0] and maya.messages == []


def test_inside_a_variant(tmp_path, press):
    make_rig(tmp_path / "rig.usda")
    stage = Usd.Stage.CreateInMemory()
    prim = stage.OverridePrim("/Rig")
    prim.GetReferences().AddReference(str(tmp_path / "rig.usda"))
    variants = prim.GetVariantSets().AddVariantSet("style")
    for name in ("snappy", "plain"):
        variants.AddVariant(name)
    variants.SetVariantSelection("snappy")
    stage.SetEditTarget(variants.GetVariantEditTarget())
    maya = press(stage.GetPrimAtPath("/Rig"))
    assert maya.warnings == [] and len(codes(stage)) == 7
    stage.SetEditTarget(stage.GetRootLayer())
    variants.SetVariantSelection("plain")
    assert len(codes(stage)) == 4


@pytest.mark.parametrize(
    ("answer", "words"),
    [("", "--factor"), ("x", "--factor"), ("2 leg:alpha=4", "leg matches no joint"), ("2 arm:alpha=-1", "alpha")],
)
def test_bad_answers_are_sentences(tmp_path, press, answer, words):
    stage = make_rig(tmp_path / "in.usda")
    maya = press(stage.GetPrimAtPath(SKELETON), answer=answer)
    assert len(maya.warnings) == 1 and words in maya.warnings[0] and codes(stage) == [0.0, 1.0, 2.0, 3.0]


def test_nothing_selected_and_second_thoughts(tmp_path, press):
    assert press().warnings == ["Select a SkelAnimation, a Skeleton or a prim above them."]
    stage = make_rig(tmp_path / "in.usda")
    maya = press(stage.GetPrimAtPath(SKELETON), answer=None)
    assert (maya.warnings, maya.messages, maya.undo) == ([], [], []) and len(codes(stage)) == 4
