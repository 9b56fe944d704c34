"""The papers' picture: a script for Blender's Python renders the original and what schemes make of it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from blender import call_blender
from rigs import make_rig, random_rotations

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
pytestmark = pytest.mark.slow


def render(*arguments):
    """Call the script; give its exit code and what it says."""
    done = call_blender(EXAMPLES / "render_overlay.py", *arguments)
    return done.returncode, done.stdout + done.stderr


def test_renders_a_scheme_over_the_original(tmp_path, run):
    pytest.importorskip("matplotlib", reason="reading the picture needs matplotlib")
    from matplotlib.image import imread

    subprocess.run(
        [sys.executable, EXAMPLES / "make_clips.py", "-o", tmp_path, "--clips", "pitching"],
        capture_output=True,
        check=True,
    )
    clip, compared, picture = tmp_path / "pitching.usda", tmp_path / "compared", tmp_path / "overlay.png"
    assert run("compare", clip, "-o", compared, "--rates", ".1", "--schemes", "constant")[0] == 0
    rebuilt = compared / "usd" / "pitching" / "0.1" / "constant.usdc"
    code, words = render(clip, rebuilt, "-o", picture, "--width", "300", "--samples", "4")
    assert code == 0 and str(picture) in words
    pixels = imread(picture)[..., :3]
    assert pixels.shape[1] == 300 and np.allclose(pixels[0, 0], 1.0, atol=0.02)
    # the original is grey; only what is laid over it is green
    greenish = pixels[..., 1] - pixels[..., 0] > 0.15
    assert greenish[:, 150:].sum() > 200 and not greenish[:, :120].any()


def test_says_what_it_cannot_render(tmp_path):
    make_rig(tmp_path / "bones.usda", codes=range(3), rotations=random_rotations(3, 3))
    code, words = render(tmp_path / "bones.usda", tmp_path / "bones.usda", "-o", tmp_path / "overlay.png")
    assert code == 1 and "has no skinned mesh" in words
    code, words = render(tmp_path / "bones.usda", tmp_path / "missing.usda", "-o", tmp_path / "overlay.png")
    assert code == 1 and "There is no file" in words
    assert not (tmp_path / "overlay.png").exists()
