"""The documented path, learn and then upsample, is never worse than upsample alone."""

import make_clips
import numpy as np
import pytest
from pxr import Usd
from real_files import CLIPS, real_file
from rigs import make_rig, random_rotations

from geomstats_anim import quality, uniform_keyframes
from usd_tools.learn import LearnOptions, learn
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.upsample import UpsampleOptions, upsample


def motion(path):
    (source,) = find_animations(Usd.Stage.Open(str(path)))
    return animation_of(read_clip(source))


def keep(path, out, frames):
    """Copy a file with some samples of its animation."""
    stage = Usd.Stage.Open(str(path))
    (source,) = find_animations(stage)
    codes = read_clip(source).codes
    layer = stage.Flatten()
    for name in ("rotations", "translations", "scales"):
        for code in set(layer.ListTimeSamplesForPath(f"{source.path}.{name}")) - set(codes[frames].tolist()):
            layer.EraseTimeSample(f"{source.path}.{name}", code)
    layer.Export(str(out))
    return codes


def errors(folder, source, frames, learned_from, rate, purpose):
    """Q_hyb of what upsample makes of some frames of a file, with a metric that was learned, and without one."""
    codes = keep(source, folder / "few.usda", frames)
    learn(learned_from or folder / "few.usda", folder / "metric.json", LearnOptions(rate=rate, purpose=purpose))
    found = []
    for metric in (folder / "metric.json", "identity"):
        upsample(folder / "few.usda", folder / "many.usda", UpsampleOptions(times=codes, metric=metric, no_cuts=True))
        found.append(quality(motion(folder / "many.usda"), motion(source), "hyb"))
    return found


def check_reconstruct(folder, source):
    """In sample: on the frames that it was learned from."""
    frames = uniform_keyframes(motion(source).n_frames, 0.3)
    learned, alone = errors(folder, source, frames, source, 0.3, "reconstruct")
    assert learned <= 1.01 * alone


def check_predict(folder, source):
    """Out of sample: on frames that nobody has seen."""
    n_frames = motion(source).n_frames
    frames = np.unique([*range(0, n_frames, 2), n_frames - 1])
    learned, alone = errors(folder, source, frames, None, 0.5, "predict")
    assert learned <= 1.01 * alone


@pytest.mark.slow
@pytest.mark.parametrize("name", CLIPS)
def test_real_clips(tmp_path, name):
    check_reconstruct(tmp_path, real_file(name))
    check_predict(tmp_path, real_file(name))


@pytest.mark.slow
def test_example_clips(tmp_path):
    assert make_clips.main(["-o", str(tmp_path / "clips")]) == 0
    for source in sorted((tmp_path / "clips").glob("*.usda")):
        (tmp_path / source.stem).mkdir()
        check_reconstruct(tmp_path / source.stem, source)
        check_predict(tmp_path / source.stem, source)


def test_a_clip(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(60), rotations=random_rotations(60, 3, seed=3))
    check_reconstruct(tmp_path, tmp_path / "in.usda")
