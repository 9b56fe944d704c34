"""Times of the samples that upsample writes: frames per second, retimed clips, lists of times."""

import json

import numpy as np
from pxr import Usd, UsdGeom
from rigs import ANIMATION, bits, make_rig, read


def test_fps_keeps_time_codes_and_retime_stretches_them(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=(10, 11, 12), rate=24)
    stage.SetStartTimeCode(10)
    stage.SetEndTimeCode(12)
    ball = UsdGeom.Sphere.Define(stage, "/Ball").CreateRadiusAttr()
    ball.Set(1.0, 10.0)
    ball.Set(2.0, 12.0)
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "keep.usda", "--fps", 48)
    assert read(tmp_path / "keep.usda")[0] == [10, 10.5, 11, 11.5, 12]
    code, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "re.usda", "--fps", 48, "--retime")
    assert (code, "set the scene's frame rate to 48." in out) == (0, True)
    assert read(tmp_path / "re.usda")[0] == [20, 21, 22, 23, 24]
    assert bits(read(tmp_path / "re.usda")[1]) == bits(read(tmp_path / "keep.usda")[1])
    for name in ("re.usda", "flat.usda"):
        flat = ["--flatten"] if name == "flat.usda" else []
        run("upsample", tmp_path / "in.usda", "-o", tmp_path / name, "--fps", 48, "--retime", *flat)
        stage = Usd.Stage.Open(str(tmp_path / name))
        assert (stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()) == (48, 48)
        assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (20, 24)
        # What we did not touch keeps its speed as well.
        assert stage.GetPrimAtPath("/Ball").GetAttribute("radius").GetTimeSamples() == [20, 24]
        assert stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples() == [20, 21, 22, 23, 24]


def test_retimed_in_betweens_are_whole_frames_wherever_a_clip_starts(tmp_path, run):
    """At 60 frames per second, frame 1001 of 24 is 2502.5; the samples of the source stay where they are."""
    make_rig(tmp_path / "in.usda", codes=range(1001, 1005), rate=24)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 60, "--retime")
    codes = read(tmp_path / "out.usda")[0]
    assert codes == [2502.5, 2503, 2504, 2505, 2506, 2507, 2507.5, 2508, 2509, 2510]


def test_times_from_a_file_and_snapping(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    (tmp_path / "times.txt").write_text("0.5\n1.0000000001, 2.25\n")
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--times", tmp_path / "times.txt")
    assert read(tmp_path / "out.usda")[0] == [0, 0.5, 1, 2, 2.25, 3]
    assert "times.txt" in (tmp_path / "out.usda").read_text()
    assert str(tmp_path) not in (tmp_path / "out.usda").read_text()


def test_fewer_frames_than_the_source_only_add(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    _, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 12)
    assert err == (
        f"warning: {ANIMATION} has 24 samples per second, more than --fps 12; upsample only adds samples; "
        "usd_tools.resample --fps keeps exactly that rate.\n"
    )
    assert read(tmp_path / "out.usda")[0] == [0, 1, 2, 3]


def test_report_of_a_retimed_file_agrees_with_the_file(tmp_path, run):
    rotations = np.zeros((5, 1, 4), dtype=np.float32)
    rotations[:, 0, 2:] = [(np.sin(a), np.cos(a)) for a in np.radians([0, 65, 70, 0, 5])]
    make_rig(tmp_path / "in.usda", codes=range(10, 15), joints=["a"], rotations=rotations)
    words = ["--report", tmp_path / "r.json", "--no-cuts"]
    call = ["upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 96, "--retime", *words]
    code, _, err = run(*call)
    assert code == 0
    report = json.loads((tmp_path / "r.json").read_text())
    (told,) = report["animations"]
    codes, _ = read(tmp_path / "out.usda")
    assert (told["first_time_code"], told["last_time_code"]) == (codes[0], codes[-1]) == (40.0, 56.0)
    assert report["time_codes_per_second"] == Usd.Stage.Open(str(tmp_path / "out.usda")).GetTimeCodesPerSecond() == 96
    assert told["rate_after"] == 96 / np.median(np.diff(codes)) and told["rate_before"] == 24
    counted = {name: channel["samples_after"] for name, channel in told["channels"].items()}
    assert counted == {name: len(read(tmp_path / "out.usda", name)[0]) for name in counted}
    assert told["samples_after"] == len(codes)
    assert sorted((step["start"], step["end"]) for step in told["wide_steps"]) == [(40.0, 44.0), (48.0, 52.0)]
    assert told["largest_step"]["start"] == 48.0 and "from time code 48 to 52" in err
    assert report["warnings"] == [line.removeprefix("warning: ") for line in err.splitlines()]
