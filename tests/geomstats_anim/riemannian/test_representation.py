"""What a space, a metric and a status print."""

import numpy as np
from geomstats.geometry.special_orthogonal import SpecialOrthogonal

from geomstats_anim import LogStatus, MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric


def test_a_metric_says_its_joints_sides_and_range():
    space = PoseSpace(3)
    assert repr(space.metric) == "PoseMetric(3 joints, left, alpha 1, beta 1)"
    assert repr(space) == f"PoseSpace(3) with {space.metric!r}"
    assert repr(PoseSpace(3, equip=False)) == "PoseSpace(3)"
    parameters = MetricParameters([2.0, 1.0, 12.345], [0.5, 0.25, 2.0], np.ones((3, 3)), ["left", "right", "right"])
    words = "3 joints, 1 left, 2 right, alpha 1 to 12.3, beta 0.25 to 2, turned axes"
    assert str(parameters) == words
    assert repr(PoseMetric(space, parameters)) == f"PoseMetric({words})"
    assert str(MetricParameters(2.0, 0.5, invariance="right")) == "1 joint, right, alpha 2, beta 0.5"


def test_an_so3_metric_says_its_side_and_matrix():
    metric = SO3InvariantMetric(SpecialOrthogonal(3, equip=False), np.diag([1.0, 2.0, 0.5]), left=False)
    assert repr(metric) == "SO3InvariantMetric(right, [[1. , 0. , 0. ], [0. , 2. , 0. ], [0. , 0. , 0.5]])"


def test_a_status_prints_its_sentence():
    assert f"{LogStatus.STALLED}" == str(LogStatus.STALLED) == str(LogStatus(1))
    assert "set a key in between" in str(LogStatus.STALLED)
    assert repr(LogStatus.STALLED) == "<LogStatus.STALLED: 1>"
