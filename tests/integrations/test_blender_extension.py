"""The Blender extension, installed from its zip into a real Blender without a window."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from blender import call_blender
from pxr import Usd

from geomstats_anim import LearnedMetric, interpolate, learn_library, quality
from geomstats_anim import rotations as quat
from geomstats_anim.learning.library.storage import dump_library
from usd_tools.learn import LearnOptions, learn
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.upsample import UpsampleOptions, upsample

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "integrations" / "blender"
PUNCHING = ROOT / "tests" / "data" / "punching.usdc"


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """The zip, built by its one command."""
    out = tmp_path_factory.mktemp("built") / "extension.zip"
    subprocess.run([sys.executable, FOLDER / "build.py", "-o", out], check=True, capture_output=True)
    return out


@pytest.fixture
def in_blender(tmp_path, archive, monkeypatch):
    """Run a script of tests/blender with the extension, in a user's folder of its own."""
    monkeypatch.setenv("BLENDER_USER_RESOURCES", str(tmp_path / "user"))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))

    def call(script, *arguments):
        done = call_blender(ROOT / "tests" / "blender" / script, archive, sys.executable, *arguments)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return call


def only_clip(path):
    """The clip of a file with one animation."""
    (source,) = find_animations(Usd.Stage.Open(str(path)))
    return read_clip(source)


def test_the_zip_is_whole_and_the_same_each_time(tmp_path, archive):
    subprocess.run([sys.executable, FOLDER / "build.py", "-o", tmp_path / "again.zip"], check=True, capture_output=True)
    assert (tmp_path / "again.zip").read_bytes() == archive.read_bytes()
    with zipfile.ZipFile(archive) as files:
        names = set(files.namelist())
        assert {"blender_manifest.toml", "__init__.py", "messages.py", "LICENSE"} <= names
        assert files.read("messages.py") == (ROOT / "usd_tools" / "serving" / "messages.py").read_bytes()
        assert b'version = "0.0.0"' not in files.read("blender_manifest.toml")


@pytest.mark.slow
def test_every_rotation_mode_undo_live_and_remove(tmp_path, in_blender):
    in_blender("run_extension.py", PUNCHING, tmp_path)
    shown = np.load(tmp_path / "filled.npz")
    assert set(shown["modes"]) == {"QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"}
    clip, metric = only_clip(PUNCHING), LearnedMetric.from_json((tmp_path / "metric.json").read_text())
    motion = animation_of(clip)
    names = [joint.rsplit("/", 1)[-1] for joint in clip.skeleton.joints]
    order = [names.index(name) for name in shown["names"]]
    keys = motion.at_frames(np.flatnonzero(np.isin(np.round(clip.codes, 6), np.round(shown["keys"], 6))))
    assert keys.n_frames == len(shown["keys"]) > 5
    expected = interpolate(keys, shown["frames"] / clip.codes_per_second, metric=metric)
    angles = quat.distance(expected.rotations[:, order], quat.from_matrix(shown["rotations"]))
    assert angles.max() < 1e-5
    np.testing.assert_allclose(shown["translations"], expected.translations[:, order], atol=1e-5)
    # what was set in Blender is what upsample finds in the file that Blender wrote
    found = stored_metric(only_clip(tmp_path / "styled.usda").source)
    assert json.loads(found.to_json()) == json.loads(metric.to_json())
    options = UpsampleOptions(factor=2, metric="stored")
    (result,) = upsample(tmp_path / "styled.usda", tmp_path / "up.usda", options).animations
    assert (result.metric, result.scheme, result.joints_without_metric) == ("stored", "geodesic-spline", ())


@pytest.mark.slow
def test_metrics_come_and_go_and_what_is_locked_stays(tmp_path, in_blender):
    learn([PUNCHING], tmp_path / "in.usda", LearnOptions(rate=0.2))
    clip = only_clip(PUNCHING)
    motion = animation_of(clip)

    def at_codes(codes):
        return motion.at_frames(np.searchsorted(clip.codes, np.array(codes) - 1e-6))

    library = learn_library([motion], gaps=(6,))
    (tmp_path / "rig.inbetween").write_bytes(dump_library(library))
    in_blender("style_extension.py", tmp_path / "in.usda", tmp_path / "rig.inbetween", tmp_path)
    found, learned = (LearnedMetric.from_json((tmp_path / name).read_text()) for name in ("found.json", "learned.json"))
    # what learn has stored, Blender finds; what was learned in Blender, upsample finds
    stored = stored_metric(only_clip(tmp_path / "in.usda").source)
    assert json.loads(found.to_json()) == json.loads(stored.to_json())
    again = only_clip(tmp_path / "again.usda")
    assert json.loads(stored_metric(again.source).to_json()) == json.loads(learned.to_json())
    kept = json.loads((tmp_path / "kept.json").read_text())
    fitted = interpolate(at_codes(kept), motion.times, metric=learned)
    assert quality(fitted, motion) == pytest.approx(learned.provenance["score"], rel=1e-3)
    assert quality(fitted, motion) < 0.95 * quality(interpolate(at_codes(kept), motion.times, "slerp"), motion)
    # the library of one clip promises nothing, so that its spline is left
    shown = np.load(tmp_path / "in_library.npz")
    keys = motion.at_frames(np.union1d(np.arange(0, motion.n_frames, 6), motion.n_frames - 1))
    expected = interpolate(keys, motion.times, "learned", metric=stored, library=library)
    (b,) = [i for i, joint in enumerate(motion.skeleton.joints) if joint.endswith(f"/{shown['bone']}")]
    turned = quat.multiply(quat.conjugate(expected.rotations[:1, b]), expected.rotations[:, b])
    theirs = quat.normalize(shown["turns"].T[:, [1, 2, 3, 0]])
    assert quat.distance(turned, quat.multiply(quat.conjugate(theirs[:1]), theirs)).max() < 1e-5
