"""The metrics under Geomstats' other backends, which it chooses when it is imported: each in a process of its own."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

import geomstats_anim

SCRIPT = """
import geomstats.backend as gs
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric

assert gs.__name__ == "geomstats." + BACKEND
metric_mat = gs.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])
so3 = SpecialOrthogonal(3, equip=False)
so3.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=metric_mat, left=False)
poses = PoseSpace(2)
poses.equip_with_metric(PoseMetric, parameters=MetricParameters([2.0, 1.0], [0.5, 3.0], invariance=("left", "right")))
for space in (so3, poses):
    points, base = space.random_point(3), space.random_point()
    vec = space.metric.log(points, base)
    unit = space.metric.random_unit_tangent_vec(base)
    path = space.metric.geodesic(base, end_point=points[0])(gs.linspace(-1.0, 2.0, 4))
    result = space.metric.log_solver.solve(points, base)
    moved = space.metric.parallel_transport(unit, base, direction=vec[0])
    normal = space.metric.normal_basis(space.random_tangent_vec(base, n_samples=space.dim), base)
    arrays = (vec, unit, path, moved, normal, space.metric.dist(points, base), space.metric.exp(vec, base), *result)
    assert all(type(array) is type(points) for array in arrays)
    assert gs.allclose(space.metric.exp(vec, base), points, atol=1e-8)
    assert gs.allclose(space.metric.dist(points, base), space.metric.norm(vec, base))
    assert gs.allclose(path[2], space.metric.exp(vec[0], base), atol=1e-8)
    assert gs.all(space.belongs(path, atol=1e-8)) and gs.all(space.is_tangent(vec, base, atol=1e-8))
    assert gs.allclose(space.metric.norm(moved, points[0]), gs.array(1.0))
assert gs.allclose(poses.exp(poses.log(points, base), base), points, atol=1e-8)
x, y = so3.lie_algebra.basis[:2]
assert gs.allclose(so3.metric.sectional_curvature(x, y), so3.metric.sectional_curvature(x, x + 2.0 * y))
"""


@pytest.mark.parametrize(("backend", "module"), [("numpy", "numpy"), ("autograd", "autograd"), ("pytorch", "torch")])
def test_results_are_the_backends_own_arrays(backend, module):
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")
    root = str(Path(geomstats_anim.__file__).parents[1])
    path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    run = subprocess.run(
        [sys.executable, "-c", f"BACKEND = {backend!r}\n{SCRIPT}"],
        env={**os.environ, "GEOMSTATS_BACKEND": backend, "PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
