"""The demonstration: a page and a picture, from nothing but the install."""

import webbrowser

import pytest
from pxr import Usd

from usd_tools import demo


@pytest.fixture
def opened(monkeypatch):
    """The addresses that a browser was asked to open."""
    addresses = []
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    return addresses


@pytest.mark.slow
def test_writes_a_page_and_a_picture(run, tmp_path, opened):
    code, out, err = run("demo", "-o", tmp_path / "demo", "--no-browser")
    assert code == 0 and err == "" and opened == []
    assert "Kept 14 of the 142 samples" in out
    page = tmp_path / "demo" / "comparison" / "index.html"
    assert str(page) in out and "geodesic-spline" in page.read_text(encoding="utf-8")
    assert (tmp_path / "demo/comparison/figures/pitching-overlay.png").read_bytes().startswith(b"\x89PNG")
    for path in (tmp_path / "demo").rglob("*.usd*"):
        assert Usd.Stage.Open(str(path)).GetPrimAtPath("/World/Biped/Animation"), path

    again = demo.demo(tmp_path / "demo")
    assert opened == [page.resolve().as_uri()]
    assert again.centimetres["geodesic-spline"][0] < again.centimetres["slerp"][0]


def test_leaves_a_strangers_folder_alone(run, tmp_path, opened):
    (tmp_path / "mine.txt").write_text("mine")
    code, out, err = run("demo", "-o", tmp_path)
    assert code == 1 and out == "" and "which usd_tools.demo did not write" in err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"] and opened == []
