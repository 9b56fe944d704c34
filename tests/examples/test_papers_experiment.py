"""The papers' experiment: one command from nothing to a page."""

import json

import papers_experiment
import pytest


@pytest.mark.slow
def test_makes_clips_and_compares_them(tmp_path, capsys):
    more = ["--rates", ".2", "--schemes", "linear", "slerp"]
    arguments = ["-o", str(tmp_path / "out"), "--clips", str(tmp_path / "clips"), *more]
    assert papers_experiment.main(arguments) == 0
    assert str(tmp_path / "out" / "index.html") in capsys.readouterr().out
    document = json.loads((tmp_path / "out" / "results.json").read_text())
    names = [clip["clip"] for clip in document["clips"]]
    assert sorted(names) == ["jumping", "pitching", "punching", "rolling", "sitting"]
    assert len(document["rows"]) == 5 * 2 * 2
    assert all(row["error"] is None for row in document["rows"])
    assert (tmp_path / "out" / "figures" / "quality.png").is_file()


def test_a_folder_that_is_not_ours_is_kept(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(papers_experiment.make_clips, "main", lambda argv: 0)
    (tmp_path / "notes.txt").write_text("mine")
    assert papers_experiment.main(["-o", str(tmp_path)]) == 1
    assert "notes.txt" in capsys.readouterr().err
