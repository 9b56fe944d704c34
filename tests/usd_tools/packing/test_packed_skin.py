"""`pack --measure skin` keeps every bound vertex within the tolerance, as OpenUSD moves it, and spends all of it."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdSkel
from rigs import SKELETON, make_rig, random_rotations
from skinning import skinned

from usd_tools.pack import PackOptions, pack
from usd_tools.unpack import unpack

CODES = range(24)


@pytest.fixture
def source(tmp_path):
    """A cloak: points far from the joints, each moved by two of them."""
    rng = np.random.default_rng(0)
    stage = make_rig(tmp_path / "in.usda", codes=CODES, rotations=random_rotations(24, 3))
    mesh = UsdGeom.Mesh.Define(stage, "/Rig/Cloak")
    mesh.CreatePointsAttr([tuple(point) for point in rng.uniform(-40.0, 40.0, (60, 3)).tolist()])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([SKELETON])
    binding.CreateJointIndicesPrimvar(False, 2).Set(rng.permuted(np.tile([0, 1, 2], (60, 1)), axis=1)[:, :2].ravel())
    share = rng.uniform(0.0, 1.0, 60)
    binding.CreateJointWeightsPrimvar(False, 2).Set(np.stack([share, 1.0 - share], axis=-1).ravel())
    stage.GetRootLayer().Save()
    return tmp_path / "in.usda"


@pytest.mark.parametrize("tolerance", [1.0, pytest.param(0.1, marks=pytest.mark.slow)])
def test_every_vertex_is_within_the_tolerance(source, tmp_path, tolerance):
    packed, back = tmp_path / "packed.usdc", tmp_path / "back.usda"

    def measured(**options):
        (animation,) = pack(source, packed, PackOptions(**options)).animations
        unpack(packed, back)
        distances = np.linalg.norm(skinned(back, CODES) - skinned(source, CODES), axis=-1)
        return animation, distances.max()

    animation, largest = measured(tolerance=tolerance, measure="skin")
    assert largest == pytest.approx(animation.errors["centimetres"]["largest"], rel=1e-3) and largest <= tolerance
    # a smaller tolerance of the shell, which the skin is not within, costs more
    shell, loose = measured(tolerance=tolerance)
    assert loose > 1.5 * tolerance
    smaller, tight, still_loose = tolerance, shell, loose
    for _ in range(4):
        smaller *= tolerance / still_loose
        tight, still_loose = measured(tolerance=smaller)
        if still_loose > 0.9 * tolerance:
            break
    assert still_loose > 0.9 * tolerance and animation.bytes_packed < 0.97 * tight.bytes_packed
