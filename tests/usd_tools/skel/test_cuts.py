"""Cuts: what jumps is told from what moves, whatever the unit and the rate; nothing leads across a cut."""

import json

import numpy as np
import pytest
from real_files import SHARED, needs_shared, real_file
from rigs import bits, make_rig, read
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.cuts import find_cuts
from usd_tools.skel.find import find_animations

SCHEMES = ("linear", "slerp", "squad", "rotation-spline", "geodesic", "geodesic-spline")
COUNT, AT = 24, 12  # samples, and the first one after the cut


def body(n_joints=8):
    """A root with two chains."""
    parents = [-1, 0, 1, 2, 3, 0, 5, 6][:n_joints]
    names = [f"j{i}" for i in range(n_joints)]
    rest = np.tile([0.0, 0.2, 0.0], (n_joints, 1))
    return Skeleton(names, parents, rest, np.tile([0.0, 0.0, 0.0, 1.0], (n_joints, 1)))


def motion(n_frames=COUNT, n_joints=8, rate=30.0, seed=0):
    """Walk and swing, with rotation vectors, shape=[F, B, 3], and translations."""
    rng = np.random.default_rng(seed)
    time = np.arange(n_frames)[:, None, None] / 30.0
    vectors = 0.5 * np.sin(rng.uniform(2.0, 6.0, (n_joints, 3)) * time + rng.uniform(0.0, 6.0, (n_joints, 3)))
    places = np.tile(body(n_joints).rest_translations, (n_frames, 1, 1))
    places[:, 0, 0] += 1.2 * time[:, 0, 0]
    return vectors, places, np.arange(n_frames) / rate


def cuts_of(vectors, places, times):
    return np.flatnonzero(find_cuts(Animation(body(vectors.shape[1]), times, quat.exp(vectors), places))) + 1


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("rate", [12.0, 30.0, 120.0, 1000.0])
def test_a_teleport_is_found_in_any_unit_and_at_any_rate(size, rate):
    vectors, places, times = motion(rate=rate)
    places[AT:, 0] += [0.0, 0.0, 2.0]
    skeleton = body()
    moved = Skeleton(skeleton.joints, skeleton.parents, size * skeleton.rest_translations, skeleton.rest_rotations)
    found = find_cuts(Animation(moved, times, quat.exp(vectors), size * places))
    np.testing.assert_array_equal(np.flatnonzero(found) + 1, [AT])


def test_another_pose_in_the_same_place_is_found():
    vectors, places, times = motion()
    vectors[AT:] = motion(COUNT, seed=1)[0][AT:] + 1.5
    np.testing.assert_array_equal(cuts_of(vectors, places, times), [AT])


def test_a_root_that_turns_round_is_found():
    vectors, places, times = motion()
    vectors[:, 0] *= 0.2
    turned = quat.exp(vectors)
    turned[AT:, 0] = quat.multiply(quat.exp(np.array([0.0, 0.0, 2.5])), turned[AT:, 0])
    found = find_cuts(Animation(body(), times, turned, places))
    np.testing.assert_array_equal(np.flatnonzero(found) + 1, [AT])


def test_a_single_joint_is_enough_where_there_is_no_other():
    vectors, places, times = motion(n_joints=1)
    vectors[AT:] += [2.0, 0.0, 0.0]
    np.testing.assert_array_equal(cuts_of(vectors, places, times), [AT])


def test_poses_that_are_held_on_whole_frames_are_steps():
    vectors, places, times = motion()
    held = (np.arange(COUNT) // 6) * 6
    np.testing.assert_array_equal(cuts_of(vectors[held], places[held], times), [6, 12, 18])


@pytest.mark.parametrize("on", [2, 3])
def test_animation_on_twos_or_threes_is_motion(on):
    vectors, places, times = motion()
    held = (np.arange(COUNT) // on) * on
    assert not len(cuts_of(vectors[held], places[held], times))


@pytest.mark.parametrize("seed", range(10))
def test_motion_is_not_cut(seed):
    assert not len(cuts_of(*motion(200, seed=seed)))


def test_a_pose_that_is_away_for_one_sample_is_no_cut():
    vectors, places, times = motion()
    vectors[AT] += 2.0
    places[AT, 0] += 1.0
    assert not len(cuts_of(vectors, places, times))


def test_a_joint_that_flips_is_no_cut_of_the_whole_pose():
    vectors, places, times = motion()
    vectors[AT:, 7] += 3.0
    assert not len(cuts_of(vectors, places, times))


def test_a_start_from_rest_is_no_cut():
    vectors, places, times = motion()
    fast = np.maximum(np.arange(COUNT) - AT, 0)[:, None, None] * 0.5
    assert not len(cuts_of(np.tile(vectors[:1], (COUNT, 1, 1)) + fast, np.tile(places[:1], (COUNT, 1, 1)), times))


def test_sparse_keys_are_no_cut():
    vectors, places, times = motion()
    vectors[AT:] += 2.0
    assert not len(cuts_of(vectors, places, 10.0 * times))


@pytest.mark.parametrize("gap", [0.01, 0.15])
def test_a_gap_of_another_length_is_no_cut(gap):
    vectors, places, times = motion()
    gaps = np.full(COUNT - 1, 0.15 if gap < 0.05 else 0.01)
    gaps[AT] = gap
    even = np.arange(COUNT)[:, None, None] * np.full((COUNT, 8, 3), 0.02)  # the same steps, one of them fast
    steady = np.concatenate([[0.0], np.cumsum(gaps)])
    assert not len(cuts_of(even, np.tile(places[:1], (COUNT, 1, 1)), steady))
    same_speed = steady[:, None, None] * np.full((COUNT, 8, 3), 1.0)  # the same speed, one step large
    assert not len(cuts_of(same_speed, np.tile(places[:1], (COUNT, 1, 1)), steady))


def test_what_rounding_leaves_is_no_cut():
    _, places, times = motion()
    places = np.tile(places[:1], (COUNT, 1, 1))
    places[AT:] += 1e-7
    assert not len(cuts_of(np.zeros((COUNT, 8, 3)), places, times))


@pytest.mark.parametrize("n_frames", [1, 2, 3, 4])
def test_short_clips_have_nothing_to_compare_with(n_frames):
    vectors, places, times = motion(n_frames)
    vectors[-1] += 2.0
    assert not len(cuts_of(vectors, places, times))


def teleport(path, count=COUNT, at=AT, jump=300.0, seed=0):
    """A file with a walk that goes on 3 metres further at a sample; centimetres."""
    rng = np.random.default_rng(seed)
    time = np.arange(count)[:, None, None] / 24.0
    turns = 0.4 * np.sin(rng.uniform(2.0, 6.0, (3, 3)) * time + rng.uniform(0.0, 6.0, (3, 3)))
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(count, 3, 4).astype(np.float32)
    places = np.tile(np.float32([0.0, 10.0, 0.0]), (count, 3, 1))
    places[:, 0, 0] += 2.0 * np.arange(count) + 3.0 * np.sin(np.arange(count))
    places[at:, 0, 2] += jump
    return make_rig(path, codes=range(count), rotations=rotations, translations=places)


def upsampled(run, source, out, *words):
    code, stdout, err = run("upsample", source, "-o", out, "--factor", 5, *words)
    assert code == 0, err
    return stdout, err


@pytest.mark.parametrize("scheme", SCHEMES)
def test_both_sides_are_what_they_are_alone(tmp_path, run, scheme):
    teleport(tmp_path / "in.usda")
    upsampled(run, tmp_path / "in.usda", tmp_path / "out.usda", "--scheme", scheme)
    channels = ("rotations", "translations")
    source = {channel: read(tmp_path / "in.usda", channel)[1] for channel in channels}
    both = {channel: read(tmp_path / "out.usda", channel) for channel in channels}
    for name, part in (("before", slice(0, AT)), ("after", slice(AT, COUNT))):
        alone = {channel: values[part] for channel, values in source.items()}
        make_rig(tmp_path / f"{name}.usda", codes=range(COUNT)[part], **alone)
        words = ["--scheme", scheme, "--no-cuts"]
        upsampled(run, tmp_path / f"{name}.usda", tmp_path / f"{name}_out.usda", *words)
        for channel, (codes, values) in both.items():
            own_codes, own_values = read(tmp_path / f"{name}_out.usda", channel)
            place = np.searchsorted(codes, own_codes)
            np.testing.assert_array_equal(np.array(codes)[place], own_codes)
            np.testing.assert_allclose(np.array(values)[place], own_values, atol=1e-5)
    codes, places = both["translations"]
    across = (np.array(codes) > AT - 1) & (np.array(codes) < AT)
    assert across.sum() == 4
    assert {values.tobytes() for values in np.array(places)[across]} == {source["translations"][AT - 1].tobytes()}


def test_cuts_are_named_and_overruled(tmp_path, run):
    teleport(tmp_path / "in.usda")
    report = tmp_path / "report.json"

    def cuts(*words):
        _, err = upsampled(run, tmp_path / "in.usda", tmp_path / "out.usda", "--report", report, *words)
        places = np.array(read(tmp_path / "out.usda", "translations")[1])[:, 0, 2]
        return json.loads(report.read_text())["animations"][0]["cuts"], err, places

    found, err, places = cuts()
    assert found == [{"start": 11.0, "end": 12.0}]
    assert "jumps from time code 11 to 12" in err and "--no-cuts" in err
    assert set(np.unique(places)) == {0.0, 300.0}
    none, err, places = cuts("--no-cuts")
    assert none == [] and "jumps" not in err
    assert places.min() < -1.0  # the spline swings back before it jumps
    given, err, places = cuts("--cut", "5,11.5")
    assert given == [{"start": 4.0, "end": 5.0}, {"start": 11.0, "end": 12.0}] and "jumps" not in err
    assert set(np.unique(places)) == {0.0, 300.0}


def test_cuts_that_cannot_be(tmp_path, refuse):
    teleport(tmp_path / "in.usda")
    words = ["upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2]
    assert "--cut 0 is between no two samples" in refuse(*words, "--cut", "3,0")
    refuse(*words, "--cut", "3", "--no-cuts", exit_code=2)
    refuse(*words, "--cut", "source", exit_code=2)


@pytest.mark.parametrize("shift", [False, True])
def test_a_sparse_file_remembers_its_cuts(tmp_path, run, shift):
    teleport(tmp_path / "in.usda", count=60, at=25)
    sparse, out = tmp_path / "sparse.usda", tmp_path / "out.usda"
    code, _, err = run("downsample", tmp_path / "in.usda", "-o", sparse, "--tolerance", 0.5, "--flatten")
    assert code == 0, err
    kept = read(sparse, "translations")[0]
    assert {24.0, 25.0} <= set(kept) and len(kept) < 40
    if shift:  # as seen through a layer offset
        (tmp_path / "shot.usda").write_text(
            "#usda 1.0\n(\n    timeCodesPerSecond = 24\n    metersPerUnit = 0.01\n    subLayers = [@./sparse.usda@ "
            "(offset = 100)]\n)\n"
        )
        sparse = tmp_path / "shot.usda"
    code, _, err = run("upsample", sparse, "-o", out, "--times", "source", "--report", tmp_path / "report.json")
    assert code == 0, err
    start = 124.0 if shift else 24.0
    cuts = json.loads((tmp_path / "report.json").read_text())["animations"][0]["cuts"]
    assert cuts == [{"start": start, "end": start + 1.0}]
    rebuilt, truth = (np.array(read(path, "translations")[1]) for path in (out, tmp_path / "in.usda"))
    assert np.abs(rebuilt[:, 0] - truth[:, 0]).max() < 0.5


def test_sparse_keys_without_cuts_stay_without(tmp_path, run):
    teleport(tmp_path / "in.usda", jump=0.0)
    sparse = tmp_path / "sparse.usda"
    assert run("downsample", tmp_path / "in.usda", "-o", sparse, "--rate", 0.5)[0] == 0
    clip = read_clip(find_animations(open_stage(sparse))[0])
    assert clip.given_cuts is not None and not len(clip.cuts)


def test_learn_and_compare_do_not_cross_cuts(tmp_path, run):
    teleport(tmp_path / "in.usda", count=40, at=20)
    report = tmp_path / "report.json"
    assert run("learn", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--report", report)[0] == 0
    (metric,) = json.loads(report.read_text())["metrics"]
    assert metric["animations"][0]["stretches"] == 2
    words = ["--rates", 0.5, "--schemes", "squad"]
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "folder", *words)[0] == 0
    document = json.loads((tmp_path / "folder" / "results.json").read_text())
    assert document["clips"][0]["stretches"] == 2
    assert document["rows"][0]["max_location_cm"] < 30.0


def test_keys_stay_bit_for_bit(tmp_path, run):
    teleport(tmp_path / "in.usda")
    upsampled(run, tmp_path / "in.usda", tmp_path / "out.usda")
    for channel in ("rotations", "translations"):
        codes, values = read(tmp_path / "out.usda", channel)
        source_codes, source_values = read(tmp_path / "in.usda", channel)
        assert bits([values[codes.index(code)] for code in source_codes]) == bits(source_values)


@needs_shared
@pytest.mark.parametrize(
    "pattern",
    [
        "clips/*.usda",
        "usd/*.usd*",
        "library/01/*.usdc",
        pytest.param("library/bandai/*_001.usdc", marks=pytest.mark.slow),
    ],
)
def test_real_motion_is_not_cut(pattern):
    for path in sorted(SHARED.glob(pattern)):
        for source in find_animations(open_stage(path)):
            clip = read_clip(source)
            assert not len(clip.cuts), (path.name, clip.path, clip.cuts)


def test_a_real_teleport_is_found():
    (source,) = find_animations(open_stage(real_file("strangers/teleport.usda")))
    assert read_clip(source).cuts.tolist() == [[10.0, 11.0]]
