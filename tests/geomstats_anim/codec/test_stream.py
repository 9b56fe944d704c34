"""Streams: what is damaged, newer or of another skeleton is refused in a sentence."""

from dataclasses import replace

import motions
import numpy as np
import pytest

from geomstats_anim.codec import StreamError, pack, unpack
from geomstats_anim.codec.stream import VERSION, fingerprint, read_stream


@pytest.fixture(scope="module")
def animation():
    return motions.motion()


@pytest.fixture(scope="module")
def stream(animation):
    return pack(animation, 0.01, effort="fast")


def test_header(animation, stream):
    header, segments = read_stream(stream, animation.skeleton)
    assert np.array_equal(header.times, animation.times)
    assert (header.has_translations, header.has_scales, header.channels) == (True, False, ())
    assert [segment.n_frames for segment in segments] == [40]
    assert read_stream(stream)[1] == []


def test_damage_is_found(animation, stream):
    rng = np.random.default_rng(0)
    for _ in range(300):
        broken = bytearray(stream)
        broken[rng.integers(len(broken))] ^= 1 << rng.integers(8)
        with pytest.raises(StreamError):
            unpack(bytes(broken), animation.skeleton)


@pytest.mark.parametrize("kept", [0, 1, 5, 6, 20, -1])
def test_streams_that_are_cut_off_are_refused(animation, stream, kept):
    with pytest.raises(StreamError):
        unpack(stream[:kept], animation.skeleton)


def test_other_versions_are_refused(animation, stream):
    with pytest.raises(StreamError, match=f"version {VERSION + 1}"):
        unpack(bytes([VERSION + 1]) + stream[1:], animation.skeleton)


def test_other_skeletons_are_refused(animation, stream):
    skeleton = animation.skeleton
    others = [
        replace(skeleton, joints=(*skeleton.joints[:-1], "other")),
        replace(skeleton, rest_translations=skeleton.rest_translations + 0.001),
        replace(skeleton, rest_rotations=np.roll(skeleton.rest_rotations, 1, axis=0)),
        replace(skeleton, bone_ends=1.1 * skeleton.bone_ends),
    ]
    for other in others:
        with pytest.raises(StreamError, match="another skeleton"):
            unpack(stream, other)


def test_rounding_and_signs_of_the_rest_pose_do_not_matter():
    skeleton = motions.rig(30)
    same = replace(
        skeleton,
        rest_translations=skeleton.rest_translations * (1.0 + 1e-12),
        rest_rotations=-skeleton.rest_rotations,
        bone_ends=skeleton.bone_ends,
    )
    assert fingerprint(same) == fingerprint(skeleton)
