"""What is served is what `interpolate` and `learn_metric` give, whatever numbers name a rotation."""

import io
import json

import numpy as np
import pytest
from gaits import gait, library
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, LearnedMetric, MetricParameters, Skeleton, interpolate, learn_metric
from geomstats_anim import rotations as quat
from geomstats_anim.learning.library.storage import dump_library, load_library
from usd_tools.serving.channels import EULER
from usd_tools.serving.messages import read_message, write_message
from usd_tools.serving.run import serve

JOINTS, PARENTS = ["hips", "hips/spine", "hips/spine/arm"], [-1, 0, 1]
RNG = np.random.default_rng(3)
REST = np.concatenate([quat.normalize(RNG.normal(size=(3, 4))), RNG.normal(size=(3, 3))], axis=1)
METRIC = LearnedMetric(
    tuple(JOINTS),
    MetricParameters([2.0, 1.0, 0.5], [0.5, 3.0, 1.0], RNG.normal(size=(3, 3)), ("left", "right", "right")),
    [1.0, 0.5, 2.0],
    "geodesic-spline",
)
TIMES, WANTED = np.array([0.0, 0.4, 0.5, 1.1, 1.5]), np.linspace(0.01, 1.49, 40)
TURNS = quat.make_continuous(Rotation.from_rotvec(RNG.normal(size=(15, 3))).as_quat().reshape(5, 3, 4))
PLACES = RNG.normal(size=(5, 3, 3))


def asked(*requests):
    """The answers of a process to requests."""
    sent, answers = io.BytesIO(), io.BytesIO()
    for header, arrays in requests:
        write_message(sent, header, arrays)
    sent.seek(0)
    serve(sent, answers)
    answers.seek(0)
    found = []
    while (message := read_message(answers)) is not None:
        found.append(message)
    return found


def request(tracks, metric=METRIC, **more):
    """A request for in-betweens of one group: joint, channel and values."""
    header = {
        "request": "in-betweens",
        "joints": JOINTS,
        "parents": PARENTS,
        "metric": json.loads(metric.to_json()),
        "metres": 1.0,
        "groups": [[[joint, channel] for joint, channel, _ in tracks]],
    }
    arrays = {"rest": REST, "0/times": TIMES, "0/wanted": WANTED}
    return {**header, **more}, arrays | {f"0/{i}": values for i, (_, _, values) in enumerate(tracks)}


def named(turns, channel):
    """Numbers of Blender's for turns, shape=[K, 4]."""
    if channel == "QUATERNION":
        return 3.0 * turns[:, [3, 0, 1, 2]]
    if channel == "AXIS_ANGLE":
        vectors = Rotation.from_quat(turns).as_rotvec()
        angles = np.linalg.norm(vectors, axis=1, keepdims=True)
        return np.concatenate([-angles, -2.0 * vectors / angles], axis=1)
    order = channel.lower()
    degrees = Rotation.from_quat(turns).as_euler(order)
    return np.unwrap(degrees[:, [order.index(axis) for axis in "xyz"]], axis=0)


def read(values, channel):
    """Turns of Blender's numbers."""
    if channel == "QUATERNION":
        return quat.normalize(values[:, [1, 2, 3, 0]])
    if channel == "AXIS_ANGLE":
        return Rotation.from_rotvec(values[:, :1] * values[:, 1:]).as_quat()
    order = channel.lower()
    return Rotation.from_euler(order, values[:, ["xyz".index(axis) for axis in order]]).as_quat()


def truth(metric=METRIC, turns=TURNS, times=TIMES, wanted=WANTED):
    skeleton = Skeleton(JOINTS, PARENTS, REST[:, 4:], REST[:, :4])
    animation = Animation(skeleton, times, quat.multiply(REST[:, :4], turns), PLACES)
    return interpolate(animation, wanted, metric=metric)


@pytest.mark.parametrize("channel", ["QUATERNION", "AXIS_ANGLE", *EULER])
def test_every_rotation_mode(channel):
    tracks = [(b, channel, named(TURNS[:, b], channel)) for b in range(3)]
    ((header, arrays),) = asked(request(tracks))
    assert header == {"done": True, "notes": []}
    expected = quat.multiply(quat.conjugate(REST[:, :4]), truth().rotations)
    for b in range(3):
        assert quat.distance(read(arrays[f"0/{b}"], channel), expected[:, b]).max() < 1e-12


@pytest.mark.parametrize("scheme", ["constant", "linear", "slerp", "squad", "rotation-spline", "geodesic"])
def test_every_scheme_and_channels_that_do_not_turn(scheme):
    metric = METRIC.for_scheme(scheme)
    sizes = np.exp(PLACES)
    tracks = [
        (1, "QUATERNION", named(TURNS[:, 1], "QUATERNION")),
        (2, "location", PLACES[:, 2]),
        (0, "scale", sizes[:, 0]),
    ]
    ((_, arrays),) = asked(request(tracks, metric))
    skeleton = Skeleton(JOINTS, PARENTS, REST[:, 4:], REST[:, :4])
    animation = Animation(skeleton, TIMES, quat.multiply(REST[:, :4], TURNS), PLACES, sizes)
    expected = interpolate(animation, WANTED, scheme, metric if scheme == "geodesic" else None)
    local = quat.multiply(quat.conjugate(REST[1, :4]), expected.rotations[:, 1])
    assert quat.distance(read(arrays["0/0"], "QUATERNION"), local).max() < 1e-12
    np.testing.assert_allclose(arrays["0/1"], expected.translations[:, 2], atol=1e-12)
    np.testing.assert_allclose(arrays["0/2"], expected.scales[:, 0], atol=1e-12)


@pytest.mark.parametrize("channel", ["XYZ", "AXIS_ANGLE"])
@pytest.mark.parametrize("angles", [[0, 7, 14, 14, 3], [0, np.pi, 0, 1, 0], np.float32([0, 2 * np.pi, 0, 0, 0])])
def test_angles_that_tell_how_far_it_goes_are_interpolated(channel, angles):
    angles = np.array(angles, dtype=float)
    still = np.zeros((5, 2))
    values = np.stack([angles, *still.T], axis=1)
    if channel == "AXIS_ANGLE":
        values = np.concatenate([angles[:, None], np.tile([0.6, 0.0, 0.8], (5, 1))], axis=1)
    ((header, arrays),) = asked(request([(0, channel, values)], LearnedMetric.plain(tuple(JOINTS), "slerp")))
    (note,) = header["notes"]
    assert note.startswith("Angles that go half a turn") and note.endswith(": hips.")
    np.testing.assert_allclose(arrays["0/0"][:, 0], np.interp(WANTED, TIMES, angles), atol=1e-12)
    np.testing.assert_allclose(arrays["0/0"][:, 1:], np.tile(values[0, 1:], (40, 1)), atol=1e-12)


@pytest.mark.parametrize("angle", [170.0, 100.0])
def test_angles_that_only_name_turns_go_the_short_way(angle):
    values = np.zeros((5, 3))
    values[:, 1] = np.radians([-angle, angle, -angle, 0.0, 10.0])
    ((_, arrays),) = asked(request([(0, "ZXY", values)], LearnedMetric.plain(tuple(JOINTS), "slerp")))
    steps = np.unwrap(values[:, 1])
    expected = np.interp(WANTED, TIMES, steps)
    assert np.abs(np.exp(1j * arrays["0/0"][:, 1]) - np.exp(1j * expected)).max() < 1e-12


def test_what_carries_the_bones_has_no_style():
    values = named(TURNS[:, 0], "QUATERNION")
    ((_, arrays),) = asked(request([(-1, "QUATERNION", values), (0, "QUATERNION", values)]))
    skeleton = Skeleton(["object"], [-1], np.zeros((1, 3)), [[0.0, 0.0, 0.0, 1.0]])
    expected = interpolate(Animation(skeleton, TIMES, TURNS[:, :1], np.zeros((5, 1, 3))), WANTED)
    assert quat.distance(read(arrays["0/0"], "QUATERNION"), expected.rotations[:, 0]).max() < 1e-12
    assert quat.distance(read(arrays["0/1"], "QUATERNION"), expected.rotations[:, 0]).max() > 1e-3


def test_in_betweens_continue_from_the_key_before():
    flips = np.array([1.0, -1.0, -1.0, 1.0, -1.0])[:, None]
    values = flips * named(TURNS[:, 0], "QUATERNION")
    ((_, arrays),) = asked(request([(0, "QUATERNION", values)]))
    before = values[np.searchsorted(TIMES, WANTED) - 1]
    assert ((arrays["0/0"] * before).sum(axis=1) > 0.0).all()


@pytest.mark.slow
def test_learning_is_that_of_the_library():
    times = np.linspace(0.0, 1.0, 21)
    turns = np.stack(
        [Rotation.from_rotvec(np.outer(np.sin(k * times), v)).as_quat() for k, v in enumerate(np.eye(3), 2)], 1
    )
    turns = quat.multiply(turns, turns[::-1])
    header, arrays = request([(b, "QUATERNION", turns[:, b][:, [3, 0, 1, 2]]) for b in range(3)])
    keys = np.array([0, 5, 12, 20])
    arrays |= {"0/times": times, "0/wanted": np.zeros(0), "keys": keys, "rest": REST}
    (*reports, (answer, _)) = asked(({**header, "request": "learn", "settings": {"purpose": "reconstruct"}}, arrays))
    skeleton = Skeleton(JOINTS, PARENTS, REST[:, 4:], REST[:, :4])
    places = np.tile(REST[:, 4:], (21, 1, 1))
    found = learn_metric(Animation(skeleton, times, quat.multiply(REST[:, :4], turns), places), keys)
    # a search may end elsewhere by the rounding of its input
    for name in ("score", "slerp_score", "plain_score"):
        assert answer["metric"]["provenance"][name] == pytest.approx(found.provenance[name], rel=1e-3)
    assert all(list(report) == ["progress"] for report, _ in reports)


@pytest.mark.slow
def test_a_library_is_used_for_whole_poses_of_its_rig(tmp_path):
    walk = gait(20)
    keys, skeleton = walk.at_frames(np.arange(0, 80, 8)), walk.skeleton
    (tmp_path / "rig.inbetween").write_bytes(dump_library(library()))
    known = load_library((tmp_path / "rig.inbetween").read_bytes())
    n = skeleton.n_joints
    header = {
        "request": "in-betweens",
        "joints": skeleton.joints,
        "parents": skeleton.parents.tolist(),
        "metric": json.loads(LearnedMetric.plain(skeleton.joints, "learned").to_json()),
        "metres": 0.01,
        "library": str(tmp_path / "rig.inbetween"),
        "up": [0.0, 1.0, 0.0],
        "groups": [[[b, "QUATERNION"] for b in range(n)]],
    }
    rest = np.concatenate([skeleton.rest_rotations, 100.0 * skeleton.rest_translations], axis=1)
    arrays = {"rest": rest, "0/times": keys.times, "0/wanted": walk.times[1:70]}
    arrays |= {f"0/{b}": keys.rotations[:, b][:, [3, 0, 1, 2]] for b in range(n)}
    alone = dict(arrays) | {"1/times": keys.times, "1/wanted": arrays["0/wanted"], "1/0": arrays["0/0"]}
    answers = asked(
        (header, arrays),
        ({**header, "up": [0.0, 0.0, 1.0]}, arrays),
        ({**header, "groups": [*header["groups"], [[0, "QUATERNION"]]]}, alone),
        ({**header, "joints": [f"other/{joint}" for joint in skeleton.joints]}, arrays),
    )
    expected = interpolate(keys, walk.times[1:70], "learned", library=known)
    shown = np.stack([read(answers[0][1][f"0/{b}"], "QUATERNION") for b in range(n)], axis=1)
    assert quat.distance(shown, expected.rotations).max() < 1e-12
    assert quat.distance(shown, interpolate(keys, walk.times[1:70]).rotations).max() > 1e-2
    for (refused, _), fault in zip(
        answers[1:], ("another axis is up", "needs whole poses", "another rig"), strict=True
    ):
        assert fault in refused["error"]


TRACK = (0, "QUATERNION", np.tile([1.0, 0.0, 0.0, 0.0], (5, 1)))


@pytest.mark.parametrize(
    "change, fault",
    [
        ({"request": "exec"}, "There is no request 'exec'"),
        ({"joints": ["a", "a", "b"]}, "unique"),
        ({"parents": [0, 1, 2]}, "parent"),
        ({"metres": 0.0}, "metres"),
        ({"metric": {"format": "x"}}, "not a metric"),
        ({"metric": None}, "not a metric"),
        ({"groups": [[[3, "location"]]]}, "no joint 3"),
        ({"groups": [[[0, "eval"]]]}, "no channel 'eval'"),
        ({"groups": [[[0, "location"]]]}, "3 finite numbers"),
        ({"parents": [-1, 0, 1 << 70]}, "cannot be understood"),
        ({"groups": 3}, "cannot be understood"),
        ({"groups": [[[0, "QUATERNION"]], []]}, "cannot be understood"),
        ({"metric": json.loads(METRIC.for_scheme("learned").to_json())}, "needs a library"),
    ],
)
def test_what_does_not_fit_is_a_sentence(change, fault):
    header, arrays = request([TRACK])
    (refused, _), (answered, _) = asked(({**header, **change}, arrays), ({"request": "hello"}, {}))
    assert fault in refused["error"] and "version" in answered


def test_a_broken_pipe_ends_it_with_a_sentence():
    sent, answers = io.BytesIO(b"junk" * 10), io.BytesIO()
    serve(sent, answers)
    answers.seek(0)
    assert "no message" in read_message(answers)[0]["error"] and read_message(answers) is None
