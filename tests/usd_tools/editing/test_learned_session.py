"""Sessions with a library of in-betweens: the motion is that of `interpolate` and of `upsample --library`."""

import json
import shlex
from functools import cache

import numpy as np
import pytest
from gaits import gait
from pxr import Usd, UsdSkel
from rigs import make_rig, random_rotations

from geomstats_anim import interpolate, learn_library
from geomstats_anim.learning.library.storage import dump_library
from usd_tools.console.errors import ToolError
from usd_tools.editing.edits import EveryNth, UseScheme
from usd_tools.editing.saving import CONTENTS, SaveOptions
from usd_tools.editing.session import EditSession
from usd_tools.metrics.attributes import read_metric
from usd_tools.skel.new_file import Character, Units, new_stage
from usd_tools.upsampling.joint_styles import Style


@cache
def library():
    return learn_library([gait(seed) for seed in range(1, 5)], gaps=(8, 16))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Hold a library of gaits, and another gait as a file."""
    folder = tmp_path_factory.mktemp("learned")
    (folder / "rig.inbetween").write_bytes(dump_library(library()))
    clip = gait(100, 81)
    names = [joint.rsplit("/", 1)[-1] for joint in clip.skeleton.joints]
    units = Units(metres=1.0, up="Y", frames_per_second=30.0)
    character = Character(clip.skeleton, names, clip.rotations, clip.translations, units=units)
    new_stage(character).GetRootLayer().Export(str(folder / "walk.usda"))
    return folder


@pytest.fixture
def session(folder):
    session = EditSession.open(folder / "walk.usda", library=folder / "rig.inbetween")
    session.apply(EveryNth(8))
    return session


def expected(session):
    keys = session.motion("original").at_frames(np.isin(session.codes, session.keys))
    return interpolate(keys, session.times, session.metric.scheme, session.metric, library=library())


def test_motion_is_that_of_interpolate_after_release(session):
    assert session.metric.scheme == "learned" and session.schemes[-1] == "learned"
    np.testing.assert_allclose(session.motion().rotations, expected(session).rotations, atol=1e-12)
    for alpha in (2.0, 3.0):
        session.drag(Style("*arm*", alpha=alpha, tension=0.8))
        assert not session.is_thorough and np.isfinite(session.poses()).all()
    session.release()
    np.testing.assert_allclose(session.motion().rotations, expected(session).rotations, atol=1e-12)
    spline = EditSession.open(session.path)
    spline.apply(EveryNth(8))
    assert session.errors().degrees.mean() < 0.8 * spline.errors().degrees.mean()


def test_a_session_is_replayed_with_its_library_only(session, folder):
    session.apply(Style("hips", alpha=2.0))
    text = session.to_json()
    stored = json.loads(text)["library"]
    assert stored["file"] == "rig.inbetween" and len(stored["sha256"]) == 64
    again = EditSession.open(session.path, library=folder / "rig.inbetween")
    again.replay(text)
    np.testing.assert_array_equal(again.poses(), session.poses())

    plain = EditSession.open(session.path)
    with pytest.raises(ToolError, match="the library rig.inbetween .*with it as --library"):
        plain.replay(text)
    with pytest.raises(ToolError, match="made with no library; open the clip without --library"):
        session.replay(plain.to_json())
    with pytest.raises(ToolError, match="file and sha256 of its library"):
        session.replay(text.replace('"rig.inbetween"', "3"))


@pytest.mark.parametrize("content", CONTENTS)
def test_the_saved_layer_is_that_of_upsample(session, tmp_path, run, monkeypatch, folder, content):
    monkeypatch.chdir(tmp_path)
    session.apply(Style("*arm*", alpha=2.0))
    result = session.save("out.usda", SaveOptions(content=content))
    metric = _metric("out.usda")
    used = metric.provenance["library"]
    assert metric.scheme == "learned" and used["file"] == "rig.inbetween" and len(used["shares"]) == 5
    if content == "metric":
        return
    values = _rotations("out.usda")
    if content == "keys":
        words = ["--times", "source", "--library", folder / "rig.inbetween"]
        assert run("upsample", "out.usda", "-o", "back.usda", *words)[0] == 0
        session.save("dense.usda", SaveOptions(content="dense"))
        assert _rotations("back.usda") == _rotations("dense.usda")
        return
    for command in result.commands:
        *_, module = shlex.split(command)[:3]
        assert run(module.removeprefix("usd_tools."), *shlex.split(command)[3:])[0] == 0
    assert _rotations("out.usda") == values
    assert dict(_metric("out.usda").provenance["library"]) == used


def test_what_does_not_fit_is_refused(session, folder, tmp_path):
    plain = EditSession.open(session.path)
    assert "learned" not in plain.schemes
    with pytest.raises(ToolError, match="needs a library; open the clip with --library"):
        plain.apply(UseScheme("learned"))
    make_rig(tmp_path / "other.usda", codes=range(6), rotations=random_rotations(6, 3))
    with pytest.raises(ToolError, match="another rig"):
        EditSession.open(tmp_path / "other.usda", library=folder / "rig.inbetween")
    with pytest.raises(ToolError, match="there is no such file"):
        EditSession.open(session.path, library=tmp_path / "none.inbetween")


@pytest.mark.slow
def test_learning_leaves_the_library_in_use(session):
    session.learn()
    assert session.metric.scheme == "learned"
    np.testing.assert_allclose(session.motion().rotations, expected(session).rotations, atol=1e-12)


def _animation(stage):
    return next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation))


def _metric(path):
    stage = Usd.Stage.Open(str(path))
    return read_metric(_animation(stage))


def _rotations(path):
    stage = Usd.Stage.Open(str(path))
    attribute = UsdSkel.Animation(_animation(stage)).GetRotationsAttr()
    return {code: list(attribute.Get(code)) for code in attribute.GetTimeSamples()}
