"""Samples at a steady rate: where new ones go beside those that are there."""

import numpy as np
import pytest
from pxr import Usd
from real_files import real_file
from rigs import make_rig, random_rotations, read

from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.frame_rates import exact_rate
from usd_tools.skel.resampling import SNAP_OF_FRAME, at_rate


@pytest.fixture
def codes_at(tmp_path):
    """Make a clip with one joint, and give its time codes at a rate."""

    def call(codes, own, rate):
        turns = random_rotations(len(codes), 1)
        make_rig(tmp_path / "in.usda", codes=codes, rotations=turns, translations=None, joints=["hips"], rate=own)
        stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
        (source,) = find_animations(stage)
        return at_rate(read_clip(source), exact_rate(rate))

    return call


@pytest.mark.parametrize("typed", [59.94, 59.9401, 60000 / 1001])
def test_television(tmp_path, run, typed):
    source = real_file("strangers/ntsc_30000_1001.usda")
    assert run("upsample", source, "-o", tmp_path / "out.usda", "--fps", typed)[0] == 0
    codes, _ = read(tmp_path / "out.usda", prim="/Root/Anim")
    assert codes == (np.arange(121) / 2).tolist()


@pytest.mark.parametrize(
    ("own", "rate"),
    [
        *((29.97, 29.97), (29.97, 30000 / 1001), (30000 / 1001, 29.97), (23.976, 23.976), (23.98, 23.976)),
        *((23.99998, 24), (24, 24), (119.88, 119.88)),
    ],
)
def test_a_clip_that_has_the_rate_does_not_change(codes_at, own, rate):
    """However long it is: frames of rates that differ in the last digits drift apart."""
    codes = np.arange(20_000) + 7.0
    np.testing.assert_array_equal(codes_at(codes, own, rate), codes)


@pytest.mark.parametrize(("own", "rate"), [(29.97, 59.94), (23.98, 47.952), (23.99998, 48), (30, 60)])
def test_twice_the_rate_halves_every_gap(codes_at, own, rate):
    codes = np.arange(20_000) + 7.0
    np.testing.assert_array_equal(codes_at(codes, own, rate), np.arange(14, 2 * 20_006 + 1) / 2)


def test_samples_beside_whole_frames_are_samples_at_the_rate(codes_at):
    codes = np.arange(40) + 0.5
    np.testing.assert_array_equal(codes_at(codes, 24, 24), codes)


@pytest.mark.parametrize(("off", "n_samples"), [(0.009, 7), (-0.009, 7), (0.011, 8), (-0.011, 8)])
def test_a_frame_within_a_hundredth_of_a_sample_is_that_sample(codes_at, off, n_samples):
    """Four samples at 24 frames per second, the third beside its frame, and frames at 48."""
    codes = [0.0, 1.0, 2.0 + off / 2, 3.0]
    found = codes_at(codes, 24, 48)
    assert len(found) == n_samples
    assert set(codes) <= set(found.tolist())


def test_rates_that_differ_are_not_taken_for_one(codes_at):
    """30 frames per second beside 29.97: they meet every 1001 frames."""
    codes = np.arange(1002.0)
    found = codes_at(codes, 30000 / 1001, 30)
    gaps = np.diff(found)
    assert len(found) > 1900
    assert gaps.min() > 0.9 * SNAP_OF_FRAME


@pytest.mark.parametrize(
    ("own", "typed", "retimed"), [(29.97, 59.94, 59.94), (29.97, 29.97, 29.97), (24, 23.976, None)]
)
def test_retimed_frames_of_television_are_whole(tmp_path, run, own, typed, retimed):
    """A source whose rate has two decimals keeps them, so that every sample of it is a whole frame."""
    make_rig(tmp_path / "in.usda", codes=range(40), rate=own)
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", typed, "--retime")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    if retimed is None:
        assert (code, "more than --fps 23.976" in err) == (0, True)
        return
    assert (code, err, stage.GetTimeCodesPerSecond()) == (0, "", retimed)
    assert read(tmp_path / "out.usda")[0] == list(range(round(39 * retimed / own) + 1))
