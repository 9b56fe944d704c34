"""Motions on the page: the body that comes out of the packed data is where it was."""

import base64
import zlib

import numpy as np
import pytest
from rigs import make_rig, random_rotations

from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import body_of
from usd_tools.characters.placement import placed
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.studies.motions import motion_data


def decoded(text, kind):
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind)


@pytest.mark.parametrize("frame", [0, 7])
def test_the_page_skins_as_we_do(tmp_path, frame):
    stage = make_rig(tmp_path / "in.usda", codes=range(12), rotations=random_rotations(12, 3))
    clip = read_clip(find_animations(stage)[0])
    names = [name for name, channel in clip.channels.items() if channel.is_animated]
    animation = next(clip.stretches(names)).keys
    data = motion_data("in", clip, {"original": animation})

    # what study.js does
    rows = np.cumsum(decoded(data["motions"]["original"], "<i2").reshape(-1, 12), axis=1, dtype="<i2")
    columns = rows[:, frame].reshape(data["joints"], 4, 3).transpose(0, 2, 1)
    matrices = columns * np.array([data["slope"]] * 3 + [data["unit"]])
    owners = decoded(data["owners"], "<u2").reshape(-1, data["influences"])
    weights = decoded(data["weights"], "<f4").reshape(owners.shape)
    offsets = decoded(data["offsets"], "<f4").reshape(*owners.shape, 3)
    moved = np.einsum("piab,pib->pia", matrices[owners][..., :3], offsets) + matrices[owners][..., 3]
    found = np.einsum("pi,pia->pa", weights, moved)

    matrices = joint_matrices(placed(clip, animation))
    (expected,) = body_of(clip, animation).joined().points(matrices[frame])
    np.testing.assert_allclose(found, expected, atol=3.0 * max(data["unit"], data["slope"]))
    faces = decoded(data["faces"], "<u4")
    assert faces.max() < len(owners) and len(faces) % 3 == 0
    low, high = data["heights"]
    assert low <= matrices[:, :, 2, 3].min() + 1e-12 and high >= matrices[:, :, 2, 3].max() - 1e-12
