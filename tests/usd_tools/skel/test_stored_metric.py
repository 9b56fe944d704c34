"""The metric of an animation: its attributes first, else the JSON beside its skeletons."""

from dataclasses import replace

import pytest
from pxr import Sdf, Usd
from rigs import ANIMATION, JOINTS, SKELETON, make_rig, some_metric

from usd_tools.metrics.attributes import write_metric
from usd_tools.metrics.strings import METRIC_JSON, write_strings
from usd_tools.skel.find import find_animations
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.upsample import UpsampleOptions, upsample_stage


def test_attributes_before_strings(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    (source,) = find_animations(stage)
    assert stored_metric(source) is None
    layer = stage.GetRootLayer()
    write_strings(layer.GetPrimAtPath(SKELETON), replace(some_metric(), quality="loc"))
    assert stored_metric(source).quality == "loc"
    write_metric(layer.GetPrimAtPath(ANIMATION), some_metric())
    assert stored_metric(source).quality == "hyb"


def test_a_binding_that_usd_ignores_counts(tmp_path):
    stage = make_rig(tmp_path / "in.usda", bind=False)
    skeleton = stage.GetPrimAtPath(SKELETON)
    skeleton.CreateRelationship("skel:animationSource").SetTargets([ANIMATION])
    write_strings(stage.GetRootLayer().GetPrimAtPath(SKELETON), some_metric())
    (source,) = find_animations(stage)
    assert stored_metric(source).to_json() == some_metric().to_json()


@pytest.mark.parametrize("whole", [True, False], ids=["with its parent", "alone"])
def test_strings_go_where_the_edit_target_can_hold_them(tmp_path, whole):
    rig = make_rig(tmp_path / "rig.usda")
    layer, animation = rig.GetRootLayer(), f"{SKELETON}/Anim"
    Sdf.CopySpec(layer, ANIMATION, layer, animation)
    rig.GetPrimAtPath(SKELETON).GetRelationship("skel:animationSource").SetTargets([animation])
    stage, path = Usd.Stage.CreateInMemory(), "/Rig" if whole else SKELETON
    stage.DefinePrim(path).GetReferences().AddReference(layer.identifier, path)
    (arc,) = Usd.PrimCompositionQuery.GetDirectReferences(stage.GetPrimAtPath(path)).GetCompositionArcs()
    stage.SetEditTarget(Usd.EditTarget(layer, arc.GetTargetNode()))
    upsample_stage(stage, UpsampleOptions(factor=2, alpha=3.0, prim=(animation,)))
    has = [stage.GetPrimAtPath(path).HasAttribute(METRIC_JSON) for path in (SKELETON, "/Rig")]
    assert has == [True, whole]
    source = next(source for source in find_animations(stage) if source.skeletons)
    assert stored_metric(source).parameters.alpha.tolist() == [3.0] * len(JOINTS)
