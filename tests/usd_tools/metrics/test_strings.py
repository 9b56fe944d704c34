"""The metric survives programs that drop what is on the SkelAnimation, and rename joints."""

import pytest
from pxr import Sdf, UsdSkel
from rigs import JOINTS, SKELETON, make_rig, some_metric, stored_metric

from usd_tools.console.errors import ToolError
from usd_tools.metrics.attributes import summary
from usd_tools.metrics.strings import METRIC_JSON, SUMMARY, carriers, read_strings, renamed, write_strings


@pytest.fixture
def stage(tmp_path):
    return make_rig(tmp_path / "in.usda")


def put(stage, path, metric):
    write_strings(stage.GetRootLayer().GetPrimAtPath(path), metric)
    return stage.GetPrimAtPath(SKELETON)


@pytest.mark.parametrize("path", [SKELETON, "/Rig"])
@pytest.mark.parametrize("axes", [False, True])
def test_round_trip(stage, path, axes):
    metric = some_metric(axes)
    skeleton = put(stage, path, metric)
    assert read_strings([skeleton], JOINTS).to_json() == metric.to_json()
    assert stage.GetPrimAtPath(path).GetAttribute(SUMMARY).Get() == summary(metric)
    assert "\n" not in stage.GetPrimAtPath(path).GetAttribute(METRIC_JSON).Get()


def test_samples_are_read_and_replaced(stage):
    skeleton = stage.GetPrimAtPath(SKELETON)
    attribute = skeleton.CreateAttribute(METRIC_JSON, Sdf.ValueTypeNames.String)
    attribute.Set(some_metric().to_json(), 7.0)  # as Blender writes it
    assert read_strings([skeleton], JOINTS).to_json() == some_metric().to_json()
    put(stage, SKELETON, some_metric(axes=True))
    assert read_strings([skeleton], JOINTS).to_json() == some_metric(axes=True).to_json()


def test_the_nearest_counts(stage):
    put(stage, "/Rig", some_metric())
    skeleton = put(stage, SKELETON, some_metric(axes=True))
    assert read_strings([skeleton], JOINTS).parameters.axes is not None


def test_an_ancestor_of_several_skeletons_carries_nothing(stage):
    skeleton = put(stage, "/Rig", some_metric())
    assert [str(prim.GetPath()) for prim in carriers(skeleton)] == [SKELETON, "/Rig"]
    UsdSkel.Skeleton.Define(stage, "/Rig/Group/Other")
    assert carriers(skeleton) == [skeleton]
    assert read_strings([skeleton], JOINTS) is None


def test_a_summary_of_an_older_version_is_no_metric(stage):
    skeleton = stage.GetPrimAtPath(SKELETON)
    assert read_strings([skeleton], JOINTS) is None
    skeleton.CreateAttribute(METRIC_JSON, Sdf.ValueTypeNames.String).Set("geodesic, 3 joints (3 left, 0 right)")
    assert read_strings([skeleton], JOINTS) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "This is not JSON"),
        ("{}", 'its "format" is not'),
        (some_metric().to_json().replace('"version": 1', '"version": 2'), "has format version 2"),
        (some_metric().to_json().replace('"geodesicMetric"', '"geodesicMetric", "x": ' + "[" * 99 + "]" * 99), "deep"),
    ],
)
def test_malformed(stage, text, words):
    skeleton = stage.GetPrimAtPath(SKELETON)
    skeleton.CreateAttribute(METRIC_JSON, Sdf.ValueTypeNames.String).Set(text)
    with pytest.raises(ToolError, match=f"^{SKELETON}: {METRIC_JSON} is invalid: .*{words}"):
        read_strings([skeleton], JOINTS)


def test_skeletons_that_differ_are_refused(stage):
    first = put(stage, SKELETON, some_metric())
    second = UsdSkel.Skeleton.Define(stage, "/Other/Skel").GetPrim()
    put(stage, "/Other/Skel", some_metric())
    assert read_strings([first, second], JOINTS).to_json() == some_metric().to_json()
    put(stage, "/Other/Skel", some_metric(axes=True))
    with pytest.raises(ToolError, match=f"{SKELETON} and /Other/Skel have different {METRIC_JSON} for one animation"):
        read_strings([first, second], JOINTS)


def test_joints_of_another_program_are_found_by_their_own_names():
    metric = some_metric(joints=["ns:hips", "ns:hips/x/ns:arm", "l/hand", "r/hand", "same"])
    there = ["same", "ns_hips", "ns_hips/ns_arm", "ns_hips/ns_arm/hand"]
    assert renamed(metric, there).joints == ("ns_hips", "ns_hips/ns_arm", "l/hand", "r/hand", "same")
    assert renamed(metric, metric.joints).to_json() == metric.to_json()


def test_the_summary_says_what_the_attributes_do(tmp_path, run, stage):
    metric = some_metric()
    put(stage, SKELETON, metric)
    stage.Save()
    code, out, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, err, "geodesic, stored metric" in out) == (0, "", True)
    assert summary(metric).split(",")[0] in run("inspect", tmp_path / "in.usda")[1]
    assert stored_metric(tmp_path / "out.usda").to_json() == metric.to_json()
