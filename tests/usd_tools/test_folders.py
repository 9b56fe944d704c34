"""Verbs on several files and on folders, as their users call them."""

import json

import pytest
from rigs import make_rig, read

from usd_tools.upsampling import run as work


@pytest.fixture
def clips(tmp_path):
    """Make a folder of three clips, one of them broken, and a text."""
    folder = tmp_path / "clips"
    (folder / "walks").mkdir(parents=True)
    make_rig(folder / "b.usda")
    make_rig(folder / "walks/a.usdc")
    (folder / "broken.usda").write_text("no usd")
    (folder / "notes.txt").write_text("notes")
    return folder


def test_a_folder_is_upsampled_and_what_fails_is_named(tmp_path, run, clips):
    out, report = tmp_path / "out", tmp_path / "out/summary.json"
    code, printed, err = run("upsample", clips, "-o", out, "--factor", 2, "--report", report)
    assert code == 1
    assert printed.splitlines() == [
        "b.usda: 4 -> 7 samples",
        "walks/a.usdc: 4 -> 7 samples",
        f"Wrote 2 files to {out}, 1 failed.",
    ]
    assert err.startswith(f"error: {clips}/broken.usda ") and err.count("\n") == 1
    assert len(read(out / "walks/a.usdc")[0]) == len(read(out / "b.usda")[0]) == 7
    summary = json.loads(report.read_text())
    assert (summary["tool"], summary["written"], summary["failed"]) == ("usd_tools.upsample", 2, 1)
    assert summary["settings"] == {"factor": 2}
    assert [file["status"] for file in summary["files"]] == ["written", "failed", "written"]
    assert summary["files"][1]["error"] in err and summary["files"][2]["source"] == "walks/a.usdc"
    assert summary["files"][0]["report"]["animations"][0]["samples_after"] == 7
    assert str(tmp_path) not in report.read_text().replace(summary["files"][1]["error"], "")


def test_one_by_one_it_is_the_same(tmp_path, run, clips):
    options = ["--fps", 60, "--alpha", 4]
    run("resample", clips / "b.usda", clips / "walks/a.usdc", "-o", tmp_path / "out", *options)
    for name in ("b.usda", "walks/a.usdc"):
        alone = tmp_path / "out" / f"alone{name[-5:]}"
        run("resample", clips / name, "-o", alone, *options)
        assert alone.read_bytes() == (tmp_path / "out" / name.split("/")[-1]).read_bytes()


def test_skip_existing_goes_on_after_an_interrupt(tmp_path, run, clips, monkeypatch):
    (clips / "broken.usda").unlink()
    called = []
    real = work.work_on_file

    def until_the_second(*arguments):
        called.append(arguments[0].name)
        if len(called) == 2:
            raise KeyboardInterrupt
        return real(*arguments)

    monkeypatch.setattr(work, "work_on_file", until_the_second)
    call = ["upsample", clips, "-o", tmp_path / "out", "--factor", 2, "--skip-existing"]
    assert run(*call)[0] == 130
    code, printed, _ = run(*call)
    assert code == 0 and called == ["b.usda", "a.usdc", "a.usdc"]
    assert printed.splitlines()[-1] == f"Wrote 1 file to {tmp_path / 'out'}, skipped 1 that is there."


def test_downsample_in_place_and_formats(tmp_path, run, clips):
    (clips / "broken.usda").unlink()
    run("downsample", clips, "-o", tmp_path / "small", "--keys", 2, "--scheme", "slerp", "--usdFormat", "usda")
    assert (tmp_path / "small/walks/a.usda").read_bytes().startswith(b"#usda")
    assert len(read(tmp_path / "small/walks/a.usda")[0]) == 2
    code, printed, _ = run("upsample", clips, "--factor", 3, "--in-place")
    assert code == 0 and printed.splitlines()[-1] == "Worked on 2 files."
    assert len(read(clips / "walks/a.usdc")[0]) == 10
    assert run("upsample", clips, "--factor", 3, "--dry-run")[1].splitlines()[0] == "b.usda: 10 -> 28 samples"


def test_options_that_make_no_sense_are_refused(tmp_path, refuse, clips):
    one = ["upsample", clips / "b.usda", "-o", tmp_path / "x.usda", "--factor", 2]
    assert refuse(*one, "--jobs", 2, exit_code=2) == "--jobs is for several files or a folder; leave it out."
    assert refuse(*one, "--skip-existing", exit_code=2).startswith("--skip-existing is for several files")
    assert refuse("upsample", clips, "--factor", 2, exit_code=2) == "name the output folder with -o/--out."
    both = ["upsample", clips, "-o", tmp_path / "out", "--factor", 2]
    assert refuse(*both, "--in-place", exit_code=2) == "--in-place changes the inputs; leave --out out."
    assert refuse(*both, "--jobs", 2, "--cpus", 2, exit_code=2).startswith("--jobs starts processes")
    picture = ["downsample", clips, "-o", tmp_path / "out", "--keys", 2, "--picture", tmp_path / "p.png"]
    assert refuse(*picture, exit_code=2).startswith("--picture is for one file")
    assert refuse("upsample", clips, "-o", clips, "--factor", 2).startswith("--out clips is the folder of the input")


@pytest.mark.slow
def test_jobs_write_the_same_bytes(tmp_path, run, clips):
    contents = []
    for name, jobs in (("one", []), ("two", ["--jobs", 2])):
        assert run("upsample", clips, "-o", tmp_path / name, "--factor", 2, *jobs)[0] == 1
        contents.append({path.name: path.read_bytes() for path in (tmp_path / name).rglob("*.usd?")})
    assert contents[0] == contents[1] and len(contents[0]) == 2
