"""Names in files and of files that hold escapes, ends of lines and directions of writing, through every verb."""

import json
import os
import subprocess
import sys

import pytest
from bvh_files import write_bvh
from rigs import make_rig, random_rotations

NASTY = "\x1b[2J\x1b]0;x\x07\n\u202eh\x9b1m"
SHOWN = r"\x1b[2J\x1b]0;x\x07\n\u202eh\x9b1m"
JOINTS = [f"hips{NASTY}", f"hips{NASTY}/arm{NASTY}"]

CALLS = {
    "upsample": ["upsample", "{in}", "-o", "{out}", "--factor", "2", "-v"],
    "style": ["upsample", "{in}", "-o", "{out}", "--factor", "2", "--joint", "arm*:alpha=3"],
    "downsample": ["downsample", "{in}", "-o", "{out}", "--keys", "8", "-v"],
    "learn": ["learn", "{in}", "-o", "{out}", "-v"],
    "compare": ["compare", "{in}", "-o", "{folder}", "--rates", ".4", "--schemes", "slerp", "geodesic", "-v"],
    "inspect": ["inspect", "{in}"],
    "inspect named": ["inspect", "{named}"],
    "upsample named": ["upsample", "{named}", "-o", "{out}", "--factor", "2"],
    "compare named": ["compare", "{named}", "-o", "{folder}", "--rates", ".4", "--schemes", "slerp"],
    "no joint": ["upsample", "{in}", "-o", "{out}", "--factor", "2", "--joint", f"leg{NASTY}:alpha=3"],
    "no prim": ["inspect", f"nothing{NASTY}.usda"],
    "not usd": ["upsample", f"nothing{NASTY}.txt", "-o", "{out}", "--factor", "2"],
    "usage": ["learn", "{in}", "-o", "{out}", "--search", NASTY],
}


@pytest.fixture
def paths(tmp_path):
    """Joints with such names; the file of "named" has one too, which OpenUSD cannot reference."""
    for name in ("in.usda", f"in{NASTY}.usda"):
        make_rig(tmp_path / name, codes=range(20), rotations=random_rotations(20, 2), joints=JOINTS)
    names = {"in": "in.usda", "named": f"in{NASTY}.usda", "out": "out.usda", "folder": "folder"}
    return {word: tmp_path / name for word, name in names.items()}


@pytest.mark.parametrize("name", CALLS)
def test_names_are_shown_and_not_obeyed(paths, run, name):
    code, out, err = run(*(word.format(**paths) for word in CALLS[name]))
    refused = ("no joint", "no prim", "not usd", "upsample named", "compare named")
    assert code == (1 if name in refused else 2 if name == "usage" else 0), err
    assert r"\x1b[2J" in out + err  # of what OpenUSD quotes, ends of lines are spaces
    for line in (out + err).splitlines():
        assert line.isprintable(), line


def test_json_escapes_them_too(paths, run):
    code, out, _ = run("inspect", paths["named"], "--json")
    assert code == 0 and all(line.isprintable() for line in out.splitlines())
    assert json.loads(out)["file"] == paths["named"].name


def test_bvh(tmp_path, run):
    write_bvh(tmp_path / "in.bvh")
    path = tmp_path / f"in{NASTY}.bvh"
    path.write_text((tmp_path / "in.bvh").read_text().replace("Frames: 5", f"Frames: 5{NASTY[:4]}"))
    code, out, err = run("from_bvh", path, "-o", tmp_path / "out.usda")
    assert code == 1 and SHOWN in err and (out + err).replace("\n", "").isprintable()


def test_a_terminal_without_the_letters_of_a_name(tmp_path):
    """Output in ASCII shows escapes, and does not fail."""
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 1), joints=["関節"])
    command = [sys.executable, "-m", "usd_tools.downsample", "in.usda", "-o", "out.usda", "--keys", "8"]
    ended = subprocess.run(
        command,
        cwd=tmp_path,
        env=os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
    )
    assert ended.returncode == 0, ended.stderr
    assert rb"\u95a2\u7bc0" in ended.stdout
