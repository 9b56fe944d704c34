"""The picture of the README: the script draws it from a generated clip."""

import importlib.util

import draw_upsampling
import make_clips
import pytest

needs_matplotlib = pytest.mark.skipif(
    importlib.util.find_spec("matplotlib") is None, reason="drawing needs matplotlib, which is not installed"
)


@pytest.mark.slow
@needs_matplotlib
def test_draws_a_generated_clip(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(draw_upsampling, "_FINE", 1)
    monkeypatch.setattr(draw_upsampling, "_SHOWN", 3)
    assert make_clips.main(["-o", str(tmp_path), "--clips", "pitching"]) == 0
    picture = tmp_path / "picture.png"
    assert draw_upsampling.main([str(tmp_path / "pitching.usda"), "-o", str(picture)]) == 0
    assert capsys.readouterr().out.split()[-1] == str(picture)

    from matplotlib.image import imread

    pixels = imread(picture)
    assert pixels.shape == (1000, 2000, 4)
    assert pixels[0, 0, 3] == 0.0  # a card with round corners
    assert pixels[500, 1000, 3] == 1.0
    assert pixels[..., :3].std() > 0.05


@needs_matplotlib
@pytest.mark.parametrize(
    ("clip", "out"), [("missing.usda", "picture.png"), ("missing.usda", "folder/picture.png"), ("text.usda", "a.png")]
)
def test_bad_input_is_one_sentence(tmp_path, capsys, clip, out):
    (tmp_path / "text.usda").write_text("#usda 1.0\n")
    assert draw_upsampling.main([str(tmp_path / clip), "-o", str(tmp_path / out)]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ") and captured.err.count("\n") == 1
    assert not (tmp_path / out).exists()


def test_says_that_it_needs_matplotlib(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(draw_upsampling, "find_spec", lambda name: None)
    assert draw_upsampling.main(["-o", str(tmp_path / "picture.png")]) == 1
    assert "needs matplotlib" in capsys.readouterr().err
