"""`compare --library`: no clip is scored by a library that has learned from it."""

import hashlib
import json

import pytest
from gait_files import write
from gaits import gait

from geomstats_anim import learn_library, quality, uniform_keyframes
from geomstats_anim.interpolation.learned_scheme import Learned
from geomstats_anim.learning.library.storage import dump_library
from usd_tools import compare
from usd_tools.console.errors import Messages
from usd_tools.learning.files import collect_training_clips

GAPS = (4, 8, 16)
SEEDS = (1, 2, 3, 4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Hold four gaits, and a library that has learned from three of them."""
    folder = tmp_path_factory.mktemp("left_out")
    for seed in SEEDS:
        write(folder / f"walk_{seed}.usdc", gait(seed, 61))
    (folder / "rig.inbetween").write_bytes(dump_library(learned(folder, SEEDS[:3])))
    return folder


def clips_of(folder, seeds):
    files = [folder / f"walk_{seed}.usdc" for seed in seeds]
    return collect_training_clips(files, (), False, Messages(None))[0]


def learned(folder, seeds):
    clips = clips_of(folder, seeds)
    provenance = {
        "files": [clip.file for clip in clips],
        "sha256": [hashlib.sha256((folder / clip.file).read_bytes()).hexdigest() for clip in clips],
        "prims": [clip.prim for clip in clips],
        "seed": 0,
    }
    return learn_library([clip.stretches[0] for clip in clips], gaps=GAPS, provenance=provenance)


def compared(folder, out, names, library="rig.inbetween"):
    paths = [str(folder / name) for name in names]
    words = ["--rates", ".13", "--schemes", "slerp", "--library", str(folder / library)]
    assert compare.main([*paths, "-o", str(out), *words]) == 0
    found = json.loads((out / "results.json").read_text())
    return found, {row["clip"]: row for row in found["rows"] if row["scheme"] == "learned" and not row["out_of_sample"]}


def scored(folder, seed, library):
    (clip,) = clips_of(folder, [seed])
    stretch = clip.stretches[0]
    keys = stretch.at_frames(uniform_keyframes(stretch.n_frames, 0.13))
    return quality(Learned(keys, None, library)(stretch.times), stretch)


def test_a_clip_of_the_library_is_scored_by_one_that_learned_from_the_others_alone(folder, tmp_path, capsys):
    found, rows = compared(folder, tmp_path / "out", ["walk_1.usdc", "walk_4.usdc"])
    assert "walk_1 is in rig.inbetween: it is scored by a library of the other clips alone" in capsys.readouterr().err
    assert rows["walk_1"]["library"] == "without this clip" and rows["walk_4"]["library"] == "as it is"
    assert rows["walk_1"]["q_hyb"] == pytest.approx(scored(folder, 1, learned(folder, (2, 3))), rel=1e-5)
    assert rows["walk_4"]["q_hyb"] == pytest.approx(scored(folder, 4, learned(folder, (1, 2, 3))), rel=1e-5)
    assert found["settings"]["library"] == "rig.inbetween" and "learned" in found["settings"]["schemes"]
    assert (tmp_path / "out" / rows["walk_1"]["usd"]).is_file()
    assert "library without this clip" in (tmp_path / "out" / "index.html").read_text()


def test_without_the_other_clips_it_is_not_scored(folder, tmp_path):
    alone = tmp_path / "alone"
    alone.mkdir()
    for name in ("walk_1.usdc", "rig.inbetween"):
        (alone / name).write_bytes((folder / name).read_bytes())
    _, rows = compared(alone, tmp_path / "out", ["walk_1.usdc"])
    assert "walk_2.usdc cannot be found; compare them together" in rows["walk_1"]["error"]
    assert rows["walk_1"]["q_hyb"] is None


def test_learned_is_named_by_its_library_alone(folder, tmp_path, capsys):
    with pytest.raises(SystemExit):
        compare.main([str(folder / "walk_1.usdc"), "-o", str(tmp_path / "out"), "--schemes", "learned"])
    assert "learned needs a library: give compare --library FILE" in " ".join(capsys.readouterr().err.split())
