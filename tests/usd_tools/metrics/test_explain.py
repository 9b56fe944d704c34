"""Which axes are stiff, in words."""

import numpy as np
import pytest

from geomstats_anim import LearnedMetric, MetricParameters
from usd_tools.metrics.explain import describe_scores, joint_meanings, table_rows


def metric(alpha, beta, axes=None, invariance="left", **provenance):
    joints = tuple(f"root/{name}" for name in "abcdef"[: len(alpha)])
    return LearnedMetric(joints, MetricParameters(alpha, beta, axes, invariance), provenance=provenance)


def test_diagonal():
    (one,) = joint_meanings(metric([4.0], [0.5], invariance="right"))
    assert (one.stiff, one.free, one.ratio, one.invariance) == ("y", "z", 8.0, "right")
    assert one.moments == (2.0, 8.0, 1.0)
    assert table_rows([one])[0] == ("a", "y", "z", "8", "2, 8, 1", "parent (right)", "not stored")


@pytest.mark.parametrize("degrees", [0.5, 20.0, 70.0])
def test_tilted_axes_are_eigenvectors(degrees):
    tilted = metric([1.0], [9.0], axes=[[np.radians(degrees), 0.0, 0.0]])
    (one,) = joint_meanings(tilted)
    values, vectors = np.linalg.eigh(tilted.parameters.matrices[0])
    stiff = np.abs(vectors[:, values.argmax()])
    off = np.degrees(np.arccos(stiff.max()))
    name = "xyz"[stiff.argmax()]
    assert one.stiff == (name if off < 1.0 else f"{name} ({off:.0f}° off)")


def test_what_matters_comes_first_and_the_rest_is_counted():
    by_joint = {
        "joints": ["root/a", "root/b", "root/c", "root/d"],
        "degrees": [1.0, 0.5, 2.0, 1.0],
        "slerp_degrees": [1.1, 1.5, 2.0, 1.0],
    }
    learned = metric([2.0, 3.0, 4.0, 1.0, 5.0], [1.0] * 5, by_joint=by_joint)
    meanings = joint_meanings(learned)
    assert [one.joint[-1] for one in meanings if one.matters] == ["b", "a"]
    assert [row[0] for row in table_rows(meanings)] == [
        "b",
        "a",
        "1 joint: do not turn",
        "1 joint: no difference, as they turn about one axis or hardly at all",
        "1 joint: as slerp",
    ]
    # gains belong to names, whatever the order of the joints
    again, _ = learned.for_joints(["root/b", "root/x", "root/a"])
    assert {one.joint: one.gain for one in joint_meanings(again)} == {"root/b": 1.0, "root/a": 0.1, "root/x": None}


def test_worth():
    unseen = {"what": ["second half"], "scores": [2.0], "slerp_scores": [1.0], "plain_scores": [1.5]}
    assert describe_scores({"score": 1.0, "slerp_score": 2.0, "plain_score": 2.0, "out_of_sample": unseen}) == [
        "In-sample: +50.0 %, beats slerp.",
        "Out-of-sample, second half: -100.0 %, loses to slerp.",
    ]
    for provenance in ({}, {"styles": ["*:alpha=4"]}, {"score": "x", "slerp_score": 1.0, "out_of_sample": unseen}):
        assert describe_scores(provenance) == []
