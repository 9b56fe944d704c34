"""What inspect prints of several files."""

import csv
import io
import json

import pytest
from pxr import Usd
from rigs import ANIMATION, SKELETON, make_rig
from walk_files import write_walk


@pytest.fixture
def takes(tmp_path):
    """Make a folder: two takes of a rig in different orders, another rig, a broken file, one without motion."""
    folder = tmp_path / "takes"
    (folder / "b").mkdir(parents=True)
    make_rig(folder / "a.usda", rate=30)
    make_rig(folder / "b/walk.usda", range(9), anim_joints=["hips/spine/arm", "hips", "hips/spine"])
    make_rig(folder / "c.usda", joints=["hips", "hips/tail"])
    Usd.Stage.CreateNew(str(folder / "empty.usda")).Save()
    (folder / "x.usda").write_text("no usd")
    return folder


def test_a_row_for_each_animation_and_the_takes_of_a_rig(run, takes):
    code, out, err = run("inspect", takes)
    assert code == 1 and err.startswith(f"error: {takes}/x.usda ")
    lines = [[cell.strip() for cell in line.split("│")[1:-1]] for line in out.splitlines() if line.startswith("│")]
    assert lines[:4] == [
        ["a.usda", "1", "3", "4", "30", "0.1", "", ""],
        ["b/walk.usda", "1", "3", "9", "24", "0.3333", "", ""],
        ["c.usda", "2", "2", "4", "24", "0.125", "", ""],
        ["empty.usda", "", "", "", "", "", "", "no skeletal animation"],
    ]
    assert out.splitlines()[-1] == "Rig 1, 3 joints: 2 takes, a.usda, b/walk.usda."


def test_csv_and_json_have_the_same_rows(run, takes):
    rows = list(csv.DictReader(io.StringIO(run("inspect", takes, "--csv")[1])))
    told = json.loads(run("inspect", takes, "--json", "--jobs", 1)[1])
    assert [row["file"] for row in rows] == ["a.usda", "b/walk.usda", "c.usda", "empty.usda", "x.usda"]
    assert rows == [{name: "" if value is None else str(value) for name, value in row.items()} for row in told["rows"]]
    assert (rows[0]["skeleton"], rows[0]["animation"], rows[0]["seconds"]) == (SKELETON, ANIMATION, "0.1")
    assert told["rigs"] == [
        {"rig": 1, "joints": 3, "files": ["a.usda", "b/walk.usda"]},
        {"rig": 2, "joints": 2, "files": ["c.usda"]},
    ]
    (alone,) = json.loads(run("inspect", takes / "a.usda", "--json")[1])["animations"]
    assert told["files"][0]["animations"] == [alone]
    assert "x.usda" in told["files"][4]["error"]


def test_options_for_several_files_are_refused_for_one(refuse, takes):
    assert refuse("inspect", takes / "a.usda", "--csv", exit_code=2).startswith("--csv is for several files")
    assert refuse("inspect", takes / "a.usda", "--jobs", 2, exit_code=2).startswith("--jobs is for several files")


def test_what_is_planted_has_a_column(run, tmp_path):
    for name in ("a", "b"):
        write_walk(tmp_path / f"{name}.usda", step=1)
    make_rig(tmp_path / "c.usda")
    out = run("inspect", tmp_path)[1]
    lines = [[cell.strip() for cell in line.split("│")[1:-1]] for line in out.splitlines() if line.startswith("│")]
    assert [line[-1] for line in lines] == ["100 %", "100 %", ""]  # and no column of metrics, which no file has
    rows = list(csv.DictReader(io.StringIO(run("inspect", tmp_path, "--csv")[1])))
    assert [(row["contacts"], row["planted"]) for row in rows] == [("1.0", "4"), ("1.0", "4"), ("", "")]
    files = json.loads(run("inspect", tmp_path, "--json")[1])["files"]
    assert [joint.rsplit("/", 1)[-1] for joint in files[0]["animations"][0]["contacts"]["joints"]] == [
        "foot_l",
        "toe_l",
        "foot_r",
        "toe_r",
    ]
