"""What is plotted of long lines, and how joints are listed."""

import numpy as np

from usd_tools.viewer.joints import joint_lines
from usd_tools.viewer.timeline import thinned


def test_thinning_keeps_every_peak():
    values = np.random.default_rng(0).normal(size=20_000)
    values[[17, 9_999]] = [50.0, -50.0]
    chosen = thinned(values, 1000)
    assert len(chosen) <= 1002 and (np.diff(chosen) > 0).all()
    assert {0, 17, 9_999, 19_999} <= set(chosen)
    np.testing.assert_array_equal(thinned(values[:1000], 1000), np.arange(1000))


def test_joints_are_a_tree_with_a_line_each():
    joints = ["hips", "hips/spine", "hips/spine/arm", "hips/leg\x1b"]
    assert joint_lines(joints, [1, 2, 3, 2]) == ["hips", "· spine", "· · arm", "· leg\\x1b"]
    twins = ["a", "a/leg", "b", "b/leg", "all joints"]
    assert len(set(joint_lines(twins, [1, 2, 1, 2, 1]))) == 5 and "all joints" not in joint_lines(
        twins, [1, 2, 1, 2, 1]
    )
