"""Which files are worked on, and where their outputs go."""

import os
from pathlib import Path

import pytest

from usd_tools.batch.tasks import find_tasks
from usd_tools.console.errors import ToolError
from usd_tools.files.paths import EXTENSIONS


def touch(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def found(inputs, out, suffix=None):
    tasks = find_tasks(inputs, out, EXTENSIONS, suffix)
    return {task.name: None if task.out is None else task.out.as_posix() for task in tasks}


def test_the_tree_is_kept_and_strangers_are_left_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    touch(
        tmp_path / "in", "b.usda", "a.USDC", "deep/er/c.usdz", "note.txt", ".hidden.usda", ".git/d.usda", "deep/e.usd"
    )
    (tmp_path / "in/link.usda").symlink_to("b.usda")
    tasks = found([Path("in")], Path("out"))
    assert tasks == {
        "a.USDC": "out/a.USDC",
        "b.usda": "out/b.usda",
        "deep/e.usd": "out/deep/e.usd",
        "deep/er/c.usdz": "out/deep/er/c.usdz",
        "link.usda": "out/link.usda",
    }
    assert found([Path("in/deep"), Path("in/b.usda")], Path("out"), ".usda") == {
        "e.usd": "out/e.usda",
        "er/c.usdz": "out/er/c.usda",
        "b.usda": "out/b.usda",
    }
    assert set(found([Path("in")], None).values()) == {None}


def test_outputs_in_the_input_folder_are_not_read_again(tmp_path):
    touch(tmp_path, "a.usda", "out/a.usda")
    assert list(found([tmp_path], tmp_path / "out")) == ["a.usda"]


@pytest.mark.parametrize(
    ("inputs", "out", "sentence"),
    [
        (["x"], "out", "x contains no file that ends in .usd, .usda, .usdc or .usdz, nor do its subfolders."),
        (["in", "other"], "out", "in/a.usda and other/a.usda have the same output out/a.usda"),
        (["in", "in/a.usda"], "out", "in/a.usda and in/a.usda have the same output out/a.usda"),
        (["in"], "in/a.usda", "--out in/a.usda is a file; name a folder, for IN is a folder or several files."),
        (["in"], "o.USDA", "--out o.USDA is a file; name a folder"),
        (["in"], "in", "--out in is the folder of the input in; choose another folder."),
        (["in/a.usda", "other/b.usda"], "other", "--out other is the folder of the input other/b.usda"),
        (["in"], "no/out", "no/out: there is no folder"),
    ],
)
def test_what_cannot_be_begun_is_refused(tmp_path, monkeypatch, inputs, out, sentence):
    monkeypatch.chdir(tmp_path)
    touch(tmp_path, "in/a.usda", "other/a.usda", "other/b.usda", "x/readme.txt")
    with pytest.raises(ToolError, match=sentence.replace(".", r"\.")):
        find_tasks([Path(each) for each in inputs], Path(out), EXTENSIONS, None)
    assert sorted(os.listdir()) == ["in", "other", "x"]
