"""ACL's bytes are told for the clips that they were measured on, whatever their files are called, and for no others."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from geomstats_anim import rotations as quat
from usd_tools.comparison.acl import CENTIMETRES, REFERENCES, acl_bytes
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

DATA = Path(__file__).parents[2] / "data"


def motion(name):
    return animation_of(read_clip(find_animations(Usd.Stage.Open(str(DATA / f"{name}.usdc")))[0]))


@pytest.mark.parametrize("name", ["sitting", "punching"])
def test_clips_are_recognised_by_their_motion(name):
    animation, sizes = motion(name), REFERENCES[name].sizes
    assert tuple(acl_bytes([animation], tolerance) for tolerance in CENTIMETRES) == sizes
    assert acl_bytes([animation], 2.0) is None
    at_another_rate = replace(animation, times=2.0 * animation.times)
    parts = [at_another_rate.at_frames(slice(0, 1)), at_another_rate]
    assert acl_bytes([at_another_rate], 1.0) == sizes[2] and acl_bytes(parts, 1.0) is None


def test_other_motion_is_not_recognised():
    animation = motion("sitting")
    turn = np.array([0.0, 0.0, np.sin(0.01), np.cos(0.01)])
    rotations = animation.rotations.copy()
    rotations[::2, 3] = quat.multiply(rotations[::2, 3], turn)
    larger = replace(animation.skeleton, rest_translations=1.01 * animation.skeleton.rest_translations)
    assert acl_bytes([replace(animation, rotations=rotations)], 1.0) is None
    assert acl_bytes([replace(animation, skeleton=larger)], 1.0) is None


def test_bytes_shrink_with_the_tolerance():
    for reference in REFERENCES.values():
        known = [size for size in reference.sizes if size is not None]
        assert known == sorted(known, reverse=True)
