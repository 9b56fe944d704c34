"""Broken BVH: one sentence with the number of the line, an exit code, nothing written."""

from functools import partial

import numpy as np
import pytest
from bvh_files import write_bvh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Usd, Vt

from usd_tools.bvh.reader import read_bvh
from usd_tools.console.errors import ToolError
from usd_tools.skel.new_file import SKELETON
from usd_tools.skel.skeleton import BONE_ENDS


@pytest.fixture
def refused(refuse, tmp_path):
    """Run from_bvh and check that it is refused politely; give the sentence."""
    return partial(refuse, "from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.usda")


def replace_line(path, number, line):
    lines = path.read_text().split("\n")
    lines[number - 1 : number] = [] if line is None else [line]
    path.write_text("\n".join(lines))


@pytest.mark.parametrize(
    ("number", "line", "sentence"),
    [
        (1, "HIERARKY", "line 1: expected HIERARCHY, but found HIERARKY; repair the file."),
        (1, "#usda 1.0", "line 1: expected HIERARCHY, but found #usda; repair the file."),
        (2, "ROOT", "line 2: ROOT has no name; give the joint one."),
        (2, "JOINT Hips", "line 2: expected ROOT, but found JOINT; repair the file."),
        (3, None, "line 3: expected {, but found OFFSET; repair the file."),
        (4, "OFFSET 1 2", "line 4: OFFSET must be three numbers, not 1 2; repair the file."),
        (4, "OFFSET", "line 4: OFFSET must be three numbers, not none; repair the file."),
        (4, "OFFSET 1 2 three", "line 4: OFFSET must be three numbers, not 1 2 three; repair the file."),
        (4, "OFFSET 1 2 nan", "line 4: OFFSET must be three numbers, not 1 2 nan; repair the file."),
        (4, "OFFSET 1 2 1e39", "line 4: OFFSET must be three numbers, not 1 2 1e39; repair the file."),
        (4, "OFFSET 1 2 -,3", "line 4: -,3 has a decimal comma; replace the commas of numbers with points."),
        (4, None, "line 5: expected OFFSET, but found JOINT; repair the file."),
        (5, None, "line 41: 18 numbers for 12 channels; repair the file."),
        (5, "CHANNELS", "line 5: CHANNELS says nothing, but 0 follow; repair the file."),
        (5, "CHANNELS 2 Xposition", "line 5: CHANNELS says 2, but 1 follow; repair the file."),
        (
            5,
            "CHANNELS 1 Wrotation",
            "line 5: Wrotation is no channel; there are Xposition, Yposition, Zposition, Xrotation, Yrotation, "
            "Zrotation.",
        ),
        (
            5,
            "CHANNELS 2 Xrotation XROTATION",
            "line 5: Xrotation is there twice; a joint has each channel once.",
        ),
        (6, "JIONT Spine", "line 6: expected JOINT or End Site or }, but found JIONT; repair the file."),
        (16, "}", "line 16: expected OFFSET, but found }; repair the file."),
        (18, "OFFSET 1 2 3", "line 18: expected JOINT or End Site or }, but found OFFSET; repair the file."),
        (17, "", "line 39: expected JOINT or End Site or }, but found MOTION; repair the file."),
        (38, "} }", "line 38: expected ROOT or MOTION, but found }; repair the file."),
        (39, "ROOT Other", "line 40: expected {, but found Frames:; repair the file."),
        (40, "Frame: 5", "line 40: expected Frames and a number, but found 'Frame: 5'."),
        (
            40,
            "Frames: 0",
            "line 40: Frames must be a whole number of at least 1, not 0; correct it.",
        ),
        (
            40,
            "Frames: x",
            "line 40: Frames must be a whole number of at least 1, not x; correct it.",
        ),
        (40, "Frames: 3", "line 45: this comes after the 3 frames of line 40; correct one of them."),
        (40, "Frames: 7", "line 46: the file ends after 5 of the 7 frames of line 40; correct one of them."),
        (41, "Frame Time:", "line 41: expected Frame Time and a number, but found 'Frame Time:'."),
        (
            41,
            "Frame Time: 0",
            "line 41: Frame Time must be a positive number of seconds, not 0; correct it, or give the rate with --fps.",
        ),
        (
            41,
            "Frame Time: -1",
            "line 41: Frame Time must be a positive number of seconds, not -1; correct it, or give the rate with "
            "--fps.",
        ),
        (
            41,
            "Frame Time: nan",
            "line 41: Frame Time must be a positive number of seconds, not nan; correct it, or give the rate with "
            "--fps.",
        ),
        (
            41,
            "Frame Time: 1/30",
            "line 41: Frame Time must be a positive number of seconds, not 1/30; correct it, or give the rate with "
            "--fps.",
        ),
        (
            41,
            "Frame Time: 0,03",
            "line 41: 0,03 has a decimal comma; replace the commas of numbers with points.",
        ),
        (43, "1 2 3", "line 43: 3 numbers for 18 channels; repair the file."),
        (43, " ".join(["1"] * 19), "line 43: 19 numbers for 18 channels; repair the file."),
        (44, " ".join(["1"] * 17 + ["nan"]), "line 44: nan is no finite number; repair the file."),
        (44, " ".join(["1"] * 17 + ["-inf"]), "line 44: -inf is no finite number; repair the file."),
        (44, " ".join(["1"] * 17 + ["1e39"]), "line 44: 1e39 is no finite number; repair the file."),
        (
            44,
            " ".join(["1"] * 17 + ["1,5"]),
            "line 44: 1,5 has a decimal comma; replace the commas of numbers with points.",
        ),
        (44, " ".join(["1"] * 17 + ["1,5,0"]), "line 44: 1,5,0 is no finite number; repair the file."),
        (44, " ".join(["1"] * 17 + ["1_0"]), "line 44: 1_0 is no finite number; repair the file."),
        (44, " ".join(["1"] * 17 + ["#"]), "line 44: # is no finite number; repair the file."),
    ],
)
def test_one_line_is_wrong(tmp_path, refused, number, line, sentence):
    write_bvh(tmp_path / "in.bvh")
    replace_line(tmp_path / "in.bvh", number, line)
    assert refused() == f"in.bvh, {sentence}"


def test_quotes_are_short(tmp_path, refused):
    (tmp_path / "in.bvh").write_text("x" * 10**6)
    assert refused() == f"in.bvh, line 1: expected HIERARCHY, but found {'x' * 40}...; repair the file."


def test_every_number_has_the_wrong_count(tmp_path, refused):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "in.bvh").write_text(text.replace("CHANNELS 1 Yrotation", "CHANNELS 0"))
    assert refused() == "in.bvh, line 42: 18 numbers for 17 channels; repair the file."


def test_no_channels(tmp_path, refused):
    text = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION\nFrames: 2\nFrame Time: 1\n\n\n"
    (tmp_path / "in.bvh").write_text(text)
    assert refused() == "in.bvh, line 11: the file ends after 0 of the 2 frames of line 8; correct one of them."


@pytest.mark.parametrize(
    ("n_lines", "sentence"),
    [
        (0, "line 1: the file ends where HIERARCHY is expected; it is cut short."),
        (6, "line 6: the file ends where { is expected; it is cut short."),
        (7, "line 7: the file ends where OFFSET or CHANNELS is expected; it is cut short."),
        (38, "line 38: the file ends where ROOT or MOTION is expected; it is cut short."),
        (39, "line 39: the file ends where Frames is expected; it is cut short."),
        (40, "line 40: the file ends where Frame Time is expected; it is cut short."),
        (41, "line 41: the file ends after 0 of the 5 frames of line 40; correct one of them."),
        (44, "line 44: the file ends after 3 of the 5 frames of line 40; correct one of them."),
    ],
)
def test_cut_short(tmp_path, refused, n_lines, sentence):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "in.bvh").write_text("".join(text.splitlines(keepends=True)[:n_lines]))
    assert refused() == f"in.bvh, {sentence}"


def test_cut_short_within_a_line(tmp_path, refused):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "in.bvh").write_text(" ".join(text.split(" ")[:-3]))
    assert refused() == "in.bvh, line 46: 15 numbers for 18 channels; repair the file."


def test_not_utf8(tmp_path, refused):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "in.bvh").write_bytes(text.replace("Head", "T\u00eate").encode("latin-1"))
    assert refused() == "in.bvh, line 10: this is not UTF-8; save the file as UTF-8 text."
    (tmp_path / "in.bvh").write_bytes(text.encode("utf-16"))
    assert refused() == "in.bvh, line 1: this is not UTF-8; save the file as UTF-8 text."


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("broken") / "in.bvh"


@given(st.data())
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_nothing_but_a_sentence_comes_of_a_broken_file(scratch, data):
    """Words are lost, doubled, swapped or spoiled: it is read, or refused with the number of a line."""
    lines = [line.split(" ") for line in write_bvh(scratch).split("\n")]
    for _ in range(data.draw(st.integers(1, 3))):
        line = lines[data.draw(st.integers(0, len(lines) - 1))]
        place = data.draw(st.integers(0, len(line)))
        line[place : place + 1] = data.draw(
            st.sampled_from([[], line[place : place + 1] * 2, ["}"], ["{"], ["ROOT", "b"], ["End"], ["CHANNELS", "1"]])
            | st.text(max_size=3).map(lambda word: [word])
        )
    scratch.write_text("\n".join(" ".join(line) for line in lines), encoding="utf-8", errors="replace")
    try:
        bvh = read_bvh(scratch)
    except ToolError as error:
        number = int(str(error).removeprefix(f"{scratch}, line ").split(":")[0])
        assert 1 <= number <= max(1, len(scratch.read_bytes().decode().splitlines()))
    else:
        assert np.isfinite(bvh.translations).all() and np.isfinite(bvh.rotations).all()


def test_missing_file(tmp_path, refused):
    assert refused() == "in.bvh: there is no such file."
    (tmp_path / "in.bvh").mkdir()
    assert refused() == "--out out.usda is a file; name a folder, for IN is a folder or several files."


def test_skip_first_of_one(tmp_path, refused):
    write_bvh(tmp_path / "in.bvh", n_frames=1)
    sentence = refused("--skip-first")
    assert sentence == "in.bvh has one frame, and --skip-first leaves it out; call it without --skip-first."


def test_output(tmp_path, refuse):
    write_bvh(tmp_path / "in.bvh")
    sentence = refuse("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.fbx")
    assert sentence == "--out out.fbx: the name must end in .usd, .usda, .usdc, .usdz."
    sentence = refuse("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "no" / "out.usda")
    assert sentence == "--out no/out.usda: there is no folder no; make it first."
    (tmp_path / "out.usda").symlink_to(tmp_path / "in.bvh")
    sentence = refuse("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.usda")
    assert sentence == "--out out.usda is the input itself; choose another name."


@pytest.mark.parametrize("option", ["--scale", "--fps"])
@pytest.mark.parametrize("number", ["0", "-1", "nan", "inf", "much"])
def test_positive_numbers(tmp_path, refused, option, number):
    write_bvh(tmp_path / "in.bvh")
    sentence = refused(f"{option}={number}", exit_code=2)
    assert sentence == f"{option}: must be a positive number, not '{number}'."


def test_usage(tmp_path, refuse):
    sentence = refuse("from_bvh", tmp_path / "in.bvh", exit_code=2)
    assert sentence == "the following arguments are required: -o/--out."


@pytest.mark.parametrize("ends", [[(1, 2, 3)], [(1, 2, np.inf)] * 5])
def test_bone_ends_that_do_not_fit(tmp_path, run, refuse, ends):
    write_bvh(tmp_path / "in.bvh")
    run("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "in.usda")
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    stage.GetPrimAtPath(SKELETON).GetAttribute(BONE_ENDS).Set(Vt.Vec3dArray(ends))
    stage.Save()
    sentence = refuse("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == (
        f"{SKELETON}: {BONE_ENDS} must be a double3[] of 5 finite vectors, one per joint; correct or remove it."
    )
