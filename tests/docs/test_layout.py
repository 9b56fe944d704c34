"""The layout in CONTRIBUTING.md is the layout on disk."""

from layout import ROOT, drawn, standing

LAYOUT = drawn((ROOT / "CONTRIBUTING.md").read_text("utf-8"))
ROOMS = {path for path in LAYOUT if path.endswith("/")}
EXPANDED = {"/".join(path.rstrip("/").split("/")[:-1]) + "/" for path in LAYOUT if path.rstrip("/").count("/")}


def test_what_is_drawn_stands():
    missing = [path for path in LAYOUT if not ((ROOT / path).is_dir() if path in ROOMS else (ROOT / path).is_file())]
    assert missing == []


def test_what_stands_is_drawn():
    assert EXPANDED >= {path for path in ROOMS if path.startswith(("geomstats_anim/", "usd_tools/"))}
    for room in EXPANDED:
        inside = (path.removeprefix(room) for path in LAYOUT if path.startswith(room))
        listed = {name for name in inside if name and "/" not in name[:-1]}
        assert listed == standing(room), room


def test_every_line_says_what_is_there():
    assert [path for path, words in LAYOUT.items() if len(words) < 8] == []
