"""Every real animated file is packed within its tolerance, and unpacked at the samples that it had."""

import json

import numpy as np
import pytest
from file_table import TABLE
from pxr import Usd
from real_files import CLIPS, SHARED, real_file

from geomstats_anim.animation import backwards
from geomstats_anim.codec import pack, unpack
from geomstats_anim.markers import Markers, world_errors
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

STRANGERS = sorted(path.name for path in (SHARED / "strangers").glob("*.usd*")) if SHARED.is_dir() else []
FILES = [name for name, row in TABLE.items() if row.downsample is None] + [f"strangers/{name}" for name in STRANGERS]
CAPTURED = ["12_01_walk_pybvh", "124_01", "animateddrawings_jumping_jacks", "animateddrawings_dab"]
LIBRARY = ["bandai/run_happy_001.usdc"]
TOLERANCE = 1.0


def clips(path):
    """Return the clips of a file that can be read, by path."""
    found = {}
    for source in find_animations(Usd.Stage.Open(str(path))):
        try:
            found[source.path] = read_clip(source)
        except Exception:  # what is broken is left as it is
            continue
    return {path: clip for path, clip in found.items() if clip.is_animated}


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES + [f"library/{name}" for name in LIBRARY])
def test_round_trip(tmp_path, name, run):
    check_round_trip(tmp_path, real_file(name), run)


@pytest.mark.slow
@pytest.mark.parametrize("name", CAPTURED)
def test_round_trip_of_motion_capture(tmp_path, name, run):
    captured = tmp_path / "captured.usdc"
    assert run("from_bvh", real_file(f"bvh/{name}.bvh"), "-o", captured)[0] == 0
    check_round_trip(tmp_path, captured, run)


def check_round_trip(tmp_path, source, run):
    packed, back = tmp_path / "packed.usdc", tmp_path / "back.usdc"
    report = tmp_path / "report.json"
    words = ["--tolerance", TOLERANCE, "--effort", "fast", "--report", report]
    code, _, err = run("pack", source, "-o", packed, *words)
    if code == 1:
        assert "no skeleton" in err or "no skeletal animation" in err
        return
    told = {each["prim"]: each for each in json.loads(report.read_text())["animations"]}
    assert told
    assert run("unpack", packed, "-o", back)[0] == 0
    before, after, read = clips(source), clips(back), clips(packed)
    for path, each in told.items():
        largest = each["errors"]["centimetres"]["largest"]
        assert largest <= TOLERANCE
        # no sample time is lost
        moving = [before[path].channels[channel] for channel in each["packed"]]
        assert set(np.concatenate([channel.codes for channel in moving])) <= set(after[path].codes)
        assert np.array_equal(after[path].codes, read[path].codes)
        for channel, ours in after[path].channels.items():
            assert np.array_equal(ours.values, read[path].channels[channel].values)
        truth, ours = animation_of(before[path]), animation_of(after[path])
        at = np.isin(ours.times, truth.times)
        markers = Markers.of_shell(truth)
        if len(truth.times) == at.sum() and truth.n_joints:
            assert 100.0 * world_errors(ours.at_frames(at), truth, markers).max() <= TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CLIPS, "usd/mayausd_HIK_Export.usda"])
def test_a_tenth_of_a_millimetre(tmp_path, name, run):
    source, packed = real_file(name), tmp_path / "packed.usdc"
    assert run("pack", source, "-o", packed, "--tolerance", 0.01, "--effort", "fast")[0] == 0
    (truth,), (ours,) = (tuple(clips(path).values()) for path in (source, packed))
    errors = world_errors(animation_of(ours), animation_of(truth), Markers.of_shell(animation_of(truth)))
    assert 0.004 < 100.0 * errors.max() <= 0.01


def moving_clip(name):
    """Return the animation of a real file that moves."""
    (clip,) = clips(real_file(f"clips/{name}.usda")).values()
    return animation_of(clip)


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [0.01, 0.03])
@pytest.mark.parametrize("name", ["sitting", "punching", "jumping", "pitching"])
def test_motion_in_reverse_costs_the_same_and_is_packed_again_alike(name, tolerance):
    animation, sizes = moving_clip(name), []
    for each in (animation, backwards(animation)):
        stream = pack(each, tolerance)
        decoded = unpack(stream, each.skeleton)
        assert world_errors(decoded, each, Markers.of_shell(each)).max() <= tolerance
        assert pack(decoded, tolerance) == stream
        sizes.append(len(stream))
    assert sizes[0] == pytest.approx(sizes[1], rel=0.05)
