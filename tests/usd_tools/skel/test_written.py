"""What is said when a file is written: the rate to play it at, and a better one for samples between time codes."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd
from rigs import make_rig

from usd_tools.skel.output import better_rate, written

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
        ([0, 0.3137, 1.7713], 1, 24, 24),
        ([0.5], 24, None, None),
    ],
)
def test_rate_of_whole_frames(codes, rate, frames_per_second, better):
    said = better_rate(np.array(codes), rate, frames_per_second)
    if better is None:
        assert said == ""
    else:
        assert said.endswith(f"write it with --fps {better} --retime, and set the scene to {better}.")


def test_one_time_code_a_second():
    said = written(Path("in.usda"), 1.0)
    assert "1 time code a second." in said and "to 1 frame a second there." in said


def test_samples_of_other_things_do_not_count(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", rate=30)
    stage.DefinePrim("/Lamp").CreateAttribute("glow", Sdf.ValueTypeNames.Float).Set(1.0, 0.5)
    stage.GetRootLayer().Save()
    assert "--retime" not in run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--times", "1,2")[1]


@pytest.mark.parametrize("out", ["out.usda", "out.usdz"])
def test_rate_of_what_upsample_wrote(tmp_path, run, out):
    make_rig(tmp_path / "in.usda", rate=30)
    said = run("upsample", tmp_path / "in.usda", "-o", tmp_path / out, "--factor", 2)[1]
    assert "--fps 60 --retime" in said
    said = run("upsample", tmp_path / "in.usda", "-o", tmp_path / out, "--fps", 60, "--retime")[1]
    assert "--retime" not in said
    assert Usd.Stage.Open(str(tmp_path / out)).GetTimeCodesPerSecond() == 60
