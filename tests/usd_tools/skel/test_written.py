"""Advice when a file is written: the rate to play it at, and one for samples that fall between frames."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd
from rigs import make_rig

from usd_tools.skel.rate_advice import between_frames, whole_frame_rate, written_at

SECONDS = [0.04166662, 0.08333331, 0.125, 0.1666666, 0.2083333]


@pytest.mark.parametrize(
    ("codes", "rate", "frames_per_second", "better"),
    [
        ([0, 1, 2, 3], 24, None, None),
        ([0, 0.25, 0.5, 0.75, 1], 24, None, 96),
        (SECONDS, 1, None, 24),
        (SECONDS, 1, 48, 48),
        (SECONDS, 1, 25, 24),
        ([0, 0.4, 0.8, 1, 1.2, 1.6, 2], 24, None, 120),
        ([0, 0.25, 0.5, 0.75, 1], 24000 / 1001, None, 95.9041),
        ([0, 0.3137, 1.7713], 24, 24, None),
        ([0, 0.3137, 1.7713], 1, 24, None),
        ([0.5], 24, None, None),
        ([0, 0.5, 1], 1, None, 12),  # nobody steps through 2 frames per second
        ([0, 0.05, 0.1], 24, None, 480),
        ([0, 0.5, 1], 29.97, None, 59.94),
        (np.union1d(np.arange(5000), np.arange(5000) * 0.4), 24, None, 120),
    ],
)
def test_rate_of_whole_frames(codes, rate, frames_per_second, better):
    advice = between_frames(np.array(codes), rate, frames_per_second)
    if better is None:
        assert advice == ""
    else:
        assert advice == f"Some samples fall between frames; use --fps {better} --retime to make each a whole frame."


@pytest.mark.parametrize("rate", [1.0, 23.976, 24.0, 30.0, 1000.0])
@pytest.mark.parametrize("factor", [2, 3, 4, 5])
def test_every_sample_is_a_whole_frame_at_the_rate(rate, factor):
    seconds = np.arange(200) / (rate * factor)
    found = whole_frame_rate(seconds, rate, None)
    if rate * factor > 1000.0:
        assert found is None
        return
    lower = [rate * k for k in range(1, 25) if 12.0 <= rate * k < found]
    assert 12.0 <= found <= 1000.0
    assert np.abs(seconds * found - np.round(seconds * found)).max() < 1e-2
    assert all(np.abs(seconds * each - np.round(seconds * each)).max() > 0.1 for each in lower)


def test_what_blender_is_told():
    assert written_at(Path("walk.usda"), 30.0) == (
        "Wrote walk.usda (30 time codes per second). Blender ignores this rate; set the scene's frame rate to 30."
    )
    assert "set the scene's frame rate to 59.9401." in written_at(Path("walk.usda"), 60000 / 1001)


def test_samples_of_other_things_do_not_count(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", rate=30)
    stage.DefinePrim("/Lamp").CreateAttribute("glow", Sdf.ValueTypeNames.Float).Set(1.0, 0.5)
    stage.GetRootLayer().Save()
    assert "--retime" not in run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--times", "1,2")[1]


@pytest.mark.parametrize("out", ["out.usda", "out.usdz"])
def test_rate_of_what_upsample_wrote(tmp_path, run, out):
    make_rig(tmp_path / "in.usda", rate=30)
    path = tmp_path / out
    lines = run("upsample", tmp_path / "in.usda", "-o", path, "--factor", 2)[1].splitlines()
    assert lines[-1] == (
        f"Wrote {path}. Some samples fall between frames; use --fps 60 --retime to make each a whole frame."
    )
    assert run("upsample", tmp_path / "in.usda", "-o", path, "--times", "1,2")[1].splitlines()[-1] == f"Wrote {path}."
    lines = run("upsample", tmp_path / "in.usda", "-o", path, "--fps", 60, "--retime")[1].splitlines()
    assert len(lines) == 2
    assert lines[-1] == (
        f"Wrote {path} (60 time codes per second). Blender ignores this rate; set the scene's frame rate to 60."
    )
    assert Usd.Stage.Open(str(tmp_path / out)).GetTimeCodesPerSecond() == 60
