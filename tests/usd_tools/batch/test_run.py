"""Files that are worked on here, in processes, and by Ray."""

import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from usd_tools.batch.options import BatchOptions
from usd_tools.batch.run import run_tasks
from usd_tools.batch.tasks import FileTask
from usd_tools.console.errors import ToolError, UsageError


@dataclass
class Copied:
    brief: str
    warnings: tuple[str, ...] = ()

    def as_dict(self):
        return {"brief": self.brief}


def copy(source, out, options, progress, warn):
    """Stand in for a verb; what a file holds says how it goes."""
    text = source.read_text()
    if text == "bad":
        raise ToolError(f"{source} is bad; repair it.")
    if text == "bug":
        raise ZeroDivisionError("oh")
    if text == "die":
        os._exit(9)
    out.write_text(options + text)
    return Copied(f"copied {text}", ("beware",))


def tasks_of(folder, **contents):
    for name, text in contents.items():
        (folder / name).write_text(text)
    return [FileTask(folder / name, name, folder / "out" / "deep" / name) for name in contents]


def check_all(folder, results):
    assert [(result.source, result.status) for result in results] == [
        ("a", "written"),
        ("b", "failed"),
        ("c", "failed"),
        ("d", "failed"),
        ("e", "written"),
    ]
    assert [result.brief for result in results] == [
        "copied 1",
        f"{folder}/b is bad; repair it.",
        "ZeroDivisionError: oh",
        f"{folder}/d: No such file or directory.",
        "copied 5",
    ]
    assert results[0].warnings == ("beware",) and results[0].report == {"brief": "copied 1"}
    assert {path.name: path.read_text() for path in (folder / "out/deep").iterdir()} == {"a": "x1", "e": "x5"}


def five(folder):
    tasks = tasks_of(folder, a="1", b="bad", c="bug", d="?", e="5")
    (folder / "d").unlink()
    return tasks


def test_a_file_that_fails_does_not_stop_the_others(tmp_path):
    done, seen = [], []
    results = run_tasks(copy, five(tmp_path), "x", BatchOptions(), done.append, lambda *state: seen.append(state))
    check_all(tmp_path, results)
    assert done == list(results)
    assert seen[-1] == (5.0, 5, "e")


@pytest.mark.slow
def test_in_processes_it_is_the_same(tmp_path):
    check_all(tmp_path, run_tasks(copy, five(tmp_path), "x", BatchOptions(jobs=2)))


@pytest.mark.slow
def test_by_ray_it_is_the_same(tmp_path, monkeypatch):
    pytest.importorskip("ray")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.chdir(tmp_path)
    check_all(tmp_path, run_tasks(copy, five(tmp_path), "x", BatchOptions(cpus=2)))


@pytest.mark.slow
def test_a_process_that_dies_is_named(tmp_path):
    results = run_tasks(copy, tasks_of(tmp_path, a="die", b="die"), "x", BatchOptions(jobs=2))
    assert [result.status for result in results] == ["failed", "failed"]
    assert all("run it again with --skip-existing and fewer --jobs." in result.brief for result in results)
    assert not (tmp_path / "out").exists()


def test_after_an_interrupt_the_others_are_done(tmp_path):
    tasks = tasks_of(tmp_path, a="1", b="2", c="3")

    def interrupted(source, *others):
        if source.name == "b":
            raise KeyboardInterrupt
        return copy(source, *others)

    with pytest.raises(KeyboardInterrupt):
        run_tasks(interrupted, tasks, "old", BatchOptions())
    assert sorted(os.listdir(tmp_path / "out/deep")) == ["a"]
    results = run_tasks(copy, tasks, "new", BatchOptions(skip_existing=True))
    assert [result.status for result in results] == ["skipped", "written", "written"]
    assert [(tmp_path / "out/deep" / name).read_text() for name in "abc"] == ["old1", "new2", "new3"]


def test_folders_that_stay_empty_are_removed(tmp_path):
    run_tasks(copy, tasks_of(tmp_path, a="bad"), "x", BatchOptions())
    assert not (tmp_path / "out").exists()


def test_processes_and_ray_exclude_each_other():
    with pytest.raises(UsageError, match="leave one of them out"):
        BatchOptions(jobs=2, cpus=2)
