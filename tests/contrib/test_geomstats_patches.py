"""Each patch for Geomstats applies to the installed release, where its fault shows without it, and is gone with it."""

import importlib.util
import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATCHES = ROOT / "contrib" / "geomstats"

METRIC = """
import geomstats.backend as gs
import numpy as np
from geomstats.geometry.invariant_metric import _InvariantMetricMatrix
from geomstats.geometry.special_orthogonal import SpecialOrthogonal

def metric(matrix, left=True):
    space = SpecialOrthogonal(3, equip=False)
    space.equip_with_metric(_InvariantMetricMatrix, metric_mat_at_identity=matrix, left=left)
    return space.metric

x, y, z = SpecialOrthogonal(3, equip=False).lie_algebra.basis
"""

CHECKS = {
    "pca-point-ndim": """
import numpy as np
from geomstats.geometry.nfold_manifold import NFoldManifold
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.geometry.invariant_metric import BiInvariantMetric
from geomstats.learning.pca import TangentPCA
from geomstats.learning.preprocessing import ToTangentSpace
space = NFoldManifold(SpecialOrthogonal(3, equip=False).equip_with_metric(BiInvariantMetric), 2)
np.random.seed(0)
base = space.random_point()
points = space.metric.exp(0.3 * space.random_tangent_vec(base, 12), base)
pca = TangentPCA(space).fit(points, base_point=base)
assert np.allclose(pca.inverse_transform(pca.transform(points)), points, atol=1e-6)
lift = ToTangentSpace(space).fit(points, base_point=base)
assert np.allclose(lift.inverse_transform(lift.transform(points)), points, atol=1e-6)
""",
    "full-metric-matrices": METRIC
    + """
matrix = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])
full = metric(matrix)
a = np.array([0.3, -0.2, 0.5])
vector = a[0] * x + a[1] * y + a[2] * z
assert np.isclose(full.squared_norm(vector), 2.0 * a @ matrix @ a)
basis = full.normal_basis([x, y, z])
assert np.allclose([[full.inner_product(u, v) for u in basis] for v in basis], np.eye(3))
moments, axes = np.linalg.eigh(matrix)
axes = axes * np.linalg.det(axes)
turned = metric(np.diag(moments))
end = full.exp(vector, np.eye(3))
assert np.allclose(axes.T @ end @ axes, turned.exp(axes.T @ vector @ axes, np.eye(3)), atol=2e-2)
""",
    "silent-bvp-failures": METRIC
    + """
import warnings
from scipy.spatial.transform import Rotation
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    far = Rotation.from_rotvec([1.0, -2.0, 2.1]).as_matrix()
    stiff = metric(np.diag([1.0, 10.0, 0.1]))
    miss = np.abs(stiff.exp(stiff.log(far, np.eye(3)), np.eye(3)) - far).max()
assert miss < 0.05 or any("not solved" in str(warning.message) for warning in caught), miss
""",
    "numpy-trapezoid": """
import numpy
if hasattr(numpy, "trapz"):  # as NumPy 2.4 is
    del numpy.trapz
    numpy.__all__.remove("trapz")
import geomstats.backend as gs
assert gs.trapz(gs.array([0.0, 1.0])) == 0.5
""",
    "curvature-sign": METRIC
    + """
matrix = np.diag([1.0, 3.0, 0.4])
# inversion of the group carries the one to the other
for u, v in ((x, y), (y, z), (x, 2.0 * y + z)):
    left, right = (metric(matrix, side).sectional_curvature(u, v) for side in (True, False))
    assert np.isclose(left, right), (left, right)
assert np.isclose(metric(matrix).sectional_curvature(x, 3.0 * y), metric(matrix).sectional_curvature(x, y))
""",
}


@pytest.fixture(scope="module")
def sources():
    """Return the folder that holds the installed Geomstats, which must be the release that the patches are for."""
    if version("geomstats") != "2.8.0":
        pytest.skip("the patches are for Geomstats 2.8.0")
    return Path(importlib.util.find_spec("geomstats").origin).parent


def run(check, folder=None):
    path = os.pathsep.join([str(folder)] if folder else [])
    environment = {**os.environ, "GEOMSTATS_BACKEND": "numpy", "PYTHONPATH": path}
    return subprocess.run([sys.executable, "-c", check], env=environment, capture_output=True, text=True)


def test_every_patch_is_checked_and_described():
    assert {path.stem for path in PATCHES.glob("*.patch")} == set(CHECKS)
    page = (PATCHES / "README.md").read_text("utf-8")
    assert all(f"`{name}.patch`" in page for name in CHECKS)


@pytest.mark.slow
@pytest.mark.parametrize("name", CHECKS)
def test_the_fault_is_gone_with_the_patch(tmp_path, sources, name):
    shutil.copytree(sources, tmp_path / "geomstats", ignore=shutil.ignore_patterns("datasets", "__pycache__", "test*"))
    if (sources / "datasets").is_dir():
        shutil.copytree(sources / "datasets", tmp_path / "geomstats" / "datasets", ignore=_no_data)
    before = run(CHECKS[name], tmp_path)
    assert before.returncode == 1 and ("Error" in before.stderr), before.stderr
    applied = subprocess.run(
        ["git", "apply", "-p1", str(PATCHES / f"{name}.patch")], cwd=tmp_path, capture_output=True, text=True
    )
    assert applied.returncode == 0, applied.stderr
    after = run(CHECKS[name], tmp_path)
    assert after.returncode == 0, after.stderr


def _no_data(folder, names):
    return [name for name in names if not name.endswith(".py") and (Path(folder) / name).is_file()]
