"""pack: the laws of what it promises."""

from dataclasses import replace

import motions
import numpy as np
import pytest

from geomstats_anim import Animation
from geomstats_anim import rotations as quat
from geomstats_anim.animation import backwards
from geomstats_anim.codec import ExtraChannel, pack, unpack, unpack_channels
from geomstats_anim.codec.stream import read_stream
from geomstats_anim.markers import Markers, world_errors
from geomstats_anim.rotations import to_matrix


def largest_error(animation, stream, shell=0.03):
    decoded = unpack(stream, animation.skeleton)
    assert decoded.times.tobytes() == animation.times.tobytes()
    return world_errors(decoded, animation, Markers.of_shell(animation, shell)).max()


def mirrored(animation):
    """The motion in a mirror, and its skeleton too: x is negated."""
    flip, turn = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0, 1.0])
    old = animation.skeleton
    skeleton = replace(
        old,
        rest_translations=old.rest_translations * flip,
        rest_rotations=old.rest_rotations * turn,
        bone_ends=old.bone_ends * flip,
    )
    return Animation(skeleton, animation.times, animation.rotations * turn, animation.translations * flip)


@pytest.mark.parametrize("effort", ["full", "fast"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-2, 0.1])
def test_no_marker_is_off_by_more_than_the_tolerance(tolerance, effort):
    animation = motions.motion()
    assert largest_error(animation, pack(animation, tolerance, effort=effort)) <= tolerance


@pytest.mark.parametrize("n_frames", [1, 2, 3, 5])
def test_few_frames(n_frames):
    animation = motions.motion(n_frames)
    assert largest_error(animation, pack(animation, 0.01)) <= 0.01


def test_the_tolerance_holds_in_the_world_with_scales():
    animation = motions.motion(scales=True)
    rng = np.random.default_rng(0)
    world = rng.normal(size=(1, 3, 4)) * np.ones((animation.n_frames, 1, 1))
    placed = replace(animation, world=world)
    stream = pack(placed, 0.01, scale_tolerance=0.002)
    assert largest_error(placed, stream) <= 0.01
    decoded = unpack(stream, animation.skeleton)
    assert decoded.world is None
    assert np.abs(decoded.scales - animation.scales).max() <= 0.002


def test_the_tolerance_holds_for_other_markers():
    animation = motions.motion()
    far = Markers.on_joints(np.arange(6), np.full((6, 3), 0.5))
    decoded = unpack(pack(animation, 0.01, markers=far), animation.skeleton)
    assert world_errors(decoded, animation, far).max() <= 0.01


def test_the_shell_has_the_size_that_is_asked_for():
    animation = motions.motion()
    assert largest_error(animation, pack(animation, 0.01, shell=0.3), shell=0.3) <= 0.01


def test_a_clip_at_rest_takes_less_than_40_bytes():
    skeleton = motions.rig(40)
    rest = Animation(skeleton, [0.0], skeleton.rest_rotations[None], skeleton.rest_translations[None])
    stream = pack(motions.held(rest, 1000), 0.01)
    assert largest_error(motions.held(rest, 1000), stream) < 1e-12
    assert len(stream) < 40


def test_a_held_pose_takes_hardly_more_than_the_pose():
    held = motions.held(motions.motion(), 2000)
    stream = pack(held, 0.01)
    assert largest_error(held, stream) <= 0.01
    assert len(stream) <= len(pack(held.at_frames([0]), 0.01)) + 2


@pytest.mark.parametrize("effort", ["full", "fast"])
def test_packing_again_gives_the_same_stream(effort):
    animation = motions.motion(60)
    stream = pack(animation, 0.01, effort=effort)
    again = unpack(stream, animation.skeleton)
    assert pack(again, 0.01, effort=effort) == stream
    in_single_precision = replace(again, rotations=np.float32(again.rotations).astype(np.float64))
    assert pack(in_single_precision, 0.01, effort=effort) == stream


def test_halving_the_tolerance_never_shrinks_the_stream():
    animation = motions.motion(60)
    sizes = [len(pack(animation, 0.08 / 2**n)) for n in range(8)]
    assert sizes == sorted(sizes)


def test_time_reversed_and_mirrored_motions_cost_the_same():
    animation = motions.motion(120, 12, seed=3)
    size = len(pack(animation, 0.003))
    assert len(pack(backwards(animation), 0.003)) == pytest.approx(size, rel=0.05)
    assert len(pack(mirrored(animation), 0.003)) == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize("segment", [None, 0.7])
def test_small_streams_are_as_small_in_reverse(segment):
    forwards = motions.motion(41, scales=True)
    face = motions.waves(np.random.default_rng(0), 41, 4)
    sizes, directions = [], []
    for animation, values in ((forwards, face), (backwards(forwards), face[::-1])):
        channels = {"face": ExtraChannel(values, 0.2)}
        stream = pack(animation, 0.05, channels=channels, effort="fast", segment=segment)
        assert largest_error(animation, stream) <= 0.05
        decoded, decoded_face = unpack(stream, animation.skeleton), unpack_channels(stream, animation.skeleton)["face"]
        assert np.abs(decoded.scales - animation.scales).max() <= 1e-3
        assert np.abs(decoded_face - values).max() <= 0.2
        assert np.array_equal(unpack(stream, animation.skeleton, slice(30, 41)).rotations, decoded.rotations[30:])
        again = {"face": ExtraChannel(decoded_face, 0.2)}
        assert pack(decoded, 0.05, channels=again, effort="fast", segment=segment) == stream
        sizes.append(len(stream))
        directions.append(read_stream(stream)[0].is_backwards)
    assert sizes[0] == pytest.approx(sizes[1], rel=0.005)  # searches are sensitive to rounding
    assert max(sizes) < 1024
    assert sorted(directions) == [False, True]


def test_searching_pays():
    animation = motions.motion(120, 12)
    assert len(pack(animation, 0.01)) < len(pack(animation, 0.01, effort="fast"))


def test_channels_are_within_their_own_tolerances():
    animation = motions.motion()
    rng = np.random.default_rng(0)
    channels = {
        "face": ExtraChannel(motions.waves(rng, 40, 7), 0.01),
        "root": ExtraChannel(100.0 * motions.waves(rng, 40, 3), 0.5),
    }
    stream = pack(animation, 0.01, channels=channels)
    decoded = unpack_channels(stream, animation.skeleton)
    assert list(decoded) == ["face", "root"]
    for name, channel in channels.items():
        assert decoded[name].shape == channel.values.shape
        assert np.abs(decoded[name] - channel.values).max() <= channel.tolerance
    assert largest_error(animation, stream) <= 0.01


def test_a_spin_of_many_turns_survives():
    animation = motions.motion(100, 3)
    spin = quat.exp(np.linspace(0.0, 40.0, 100)[:, None] * np.array([0.0, 0.6, 0.8]))
    rotations = animation.rotations.copy()
    rotations[:, 1] = quat.multiply(rotations[:, 1], spin)
    spinning = replace(animation, rotations=rotations)
    assert largest_error(spinning, pack(spinning, 0.005)) <= 0.005


def test_segments_decode_alone():
    animation = motions.motion(90)
    stream = pack(animation, 0.01, segment=1.0)
    whole = unpack(stream, animation.skeleton)
    for frames in (slice(0, 30), slice(31, 59), slice(45, 90), slice(89, 90), slice(-3, None)):
        part, same = unpack(stream, animation.skeleton, frames), whole.at_frames(frames)
        assert np.array_equal(part.times, same.times)
        assert np.abs(to_matrix(part.rotations) - to_matrix(same.rotations)).max() < 1e-12
        assert np.array_equal(part.translations, same.translations)
    assert len(stream) < 1.6 * len(pack(animation, 0.01))


def test_a_cut_that_is_told_costs_less():
    first, second = motions.motion(40), motions.motion(40, seed=0, size=-1.2)
    joined = Animation(
        first.skeleton,
        np.arange(80) / 30.0,
        np.concatenate([first.rotations, second.rotations]),
        np.concatenate([first.translations, second.translations + 3.0]),
    )
    stream = pack(joined, 0.01, cuts=[40])
    assert largest_error(joined, stream) <= 0.01
    assert len(stream) < len(pack(joined, 0.01))


def test_progress_ends_at_all_frames():
    calls = []
    pack(motions.motion(), 0.01, segment=0.5, progress=lambda done, total: calls.append((done, total)))
    assert [done for done, _ in calls] == [15, 30, 40] and {total for _, total in calls} == {40}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tolerance": 0.0}, "tolerance is 0"),
        ({"tolerance": np.nan}, "tolerance is nan"),
        ({"segment": -1.0}, "segment is -1"),
        ({"effort": "great"}, "effort is 'great'"),
        ({"channels": {"face": ExtraChannel(np.zeros((3, 2)), 0.1)}}, "'face' has shape"),
        ({"channels": {"face": ExtraChannel(np.full((40, 2), np.inf), 0.1)}}, "'face' has a value"),
        ({"channels": {"face": ExtraChannel(np.zeros((40, 2)), 0.0)}}, "tolerance of channel 'face'"),
    ],
)
def test_what_cannot_be_packed_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        pack(motions.motion(), **{"tolerance": 0.01, **options})


def test_no_frame_is_refused():
    with pytest.raises(ValueError, match="no frame"):
        pack(motions.motion().at_frames(slice(0, 0)), 0.01)
