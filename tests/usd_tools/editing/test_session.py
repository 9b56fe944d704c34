"""A session of edits: what it shows is what `interpolate` gives, and every edit can be undone, replayed and saved."""

import json
import shlex
from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from rigs import ANIMATION, bits, make_rig, random_rotations, read

from geomstats_anim import LearnedMetric, interpolate
from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import world_pose
from geomstats_anim.names import OWN_SCHEMES, WITH_METRIC
from usd_tools.console.errors import ToolError
from usd_tools.editing import EditSession
from usd_tools.editing.edits import (
    ChooseKeys,
    EveryNth,
    FreeKey,
    KeepOnly,
    Mirror,
    PinKey,
    Reset,
    UseMetric,
    UseScheme,
    as_dict,
    exactly,
    from_dict,
)
from usd_tools.editing.history import autosave_path, read_session, write_session
from usd_tools.editing.presets import PRESETS, read_presets, write_preset
from usd_tools.editing.saving import CONTENTS, SaveOptions
from usd_tools.editing.state import counterpart
from usd_tools.upsampling.joint_styles import Style

JOINTS = ["hips", "hips/LeftArm", "hips/RightArm"]


@pytest.fixture
def session(tmp_path):
    n = 40
    make_rig(tmp_path / "clip.usda", range(n), random_rotations(n, 3, size=0.9), joints=JOINTS)
    return EditSession.open(tmp_path / "clip.usda")


EDITS = {
    "style": Style("*Arm", alpha=4.0, tension=0.5),
    "translation tension": Style("hips", translation_tension=2.0),
    "side": Style("hips", invariance="right", beta=0.3, axes=(10.0, 0.0, 45.0)),
    "scheme": UseScheme("geodesic"),
    "scheme without a metric": UseScheme("squad"),
    "metric": UseMetric(LearnedMetric.plain(JOINTS, "geodesic-spline", tension=1.5)),
    "reset": Reset("*Left*"),
    "mirror": Mirror("*Left*"),
    "every nth": EveryNth(7),
    "chosen": ChooseKeys(6),
    "exactly these": KeepOnly((0.0, 11.0, 20.0, 39.0)),
    "pin": PinKey(5.0),
    "free": FreeKey(8.0),
}


def shown(session):
    """Everything that is seen of a session, as bytes."""
    motion, errors = session.motion(), session.errors()
    arrays = motion.rotations, motion.translations, session.poses(), errors.degrees, errors.centimetres, session.keys
    return [array.tobytes() for array in arrays]


def test_undone_to_the_start_everything_is_as_it_was_bit_for_bit(session):
    start, text = shown(session), session.to_json()
    for edit in EDITS.values():
        session.apply(edit)
        shown(session)
    end = shown(session)
    assert end != start
    while session.can_undo:
        session.undo()
    assert shown(session) == start and session.to_json() == text and session.edits == ()
    while session.can_redo:
        session.redo()
    assert shown(session) == end and session.edits == tuple(EDITS.values())


def test_a_new_edit_forgets_what_was_undone(session):
    session.apply(EveryNth(4))
    session.undo()
    session.apply(EveryNth(5))
    assert not session.can_redo


@pytest.mark.parametrize("name", EDITS)
def test_after_each_edit_the_curve_is_that_of_interpolate(session, name):
    session.apply(EveryNth(6), Style("hips", alpha=2.0, beta=0.7))
    session.poses()
    session.drag(EDITS[name])
    session.poses()
    session.release()
    keys = session.motion("original").at_frames(np.flatnonzero(np.isin(session.codes, session.keys)))
    scheme = session.metric.scheme
    expected = interpolate(keys, session.times, scheme, session.metric if scheme in WITH_METRIC else None)
    ours = session.motion()
    np.testing.assert_allclose(ours.rotations, expected.rotations, atol=1e-12, rtol=0.0)
    np.testing.assert_allclose(ours.translations, expected.translations, atol=1e-12, rtol=0.0)
    slerped = interpolate(keys, session.times, "slerp")
    np.testing.assert_allclose(session.motion("slerp").rotations, slerped.rotations, atol=1e-12, rtol=0.0)


@pytest.mark.parametrize("scheme", OWN_SCHEMES)
def test_poses_at_any_time_are_those_of_the_curve(session, scheme):
    session.apply(EveryNth(9), UseScheme(scheme))
    times = np.linspace(session.times[0], session.times[-1], 23)
    keys = session.motion("original").at_frames(np.flatnonzero(np.isin(session.codes, session.keys)))
    expected = world_pose(interpolate(keys, times, scheme))
    np.testing.assert_allclose(session.poses(times=times)[..., 3], expected.origins, atol=1e-12)
    for name in ("ours", "original", "slerp"):
        at_frames = session.poses(name, times=session.times)
        np.testing.assert_allclose(at_frames, session.poses(name), atol=1e-12)
        np.testing.assert_array_equal(session.poses(name, frames=3), session.poses(name)[3])


def test_errors_are_the_angles_and_distances_from_the_file(session):
    session.apply(EveryNth(10))
    errors, original = session.errors(), session.motion("original")
    assert (errors.frames == np.arange(40)).all()
    at_key = np.isin(session.codes, session.keys)
    assert errors.degrees[at_key].max() < 1e-12 and errors.centimetres[at_key].max() < 1e-12
    ends = [world_pose(motion).ends for motion in (session.motion(), original)]
    np.testing.assert_allclose(errors.centimetres, 100.0 * np.linalg.norm(ends[0] - ends[1], axis=-1), atol=1e-10)
    assert errors.degrees.max() > 1.0


def test_a_preview_is_near_and_dragging_leaves_one_step(session):
    session.apply(EveryNth(8))
    for alpha in np.geomspace(1.0, 6.0, 9):
        session.drag(Style("*Arm", alpha=float(alpha)))
        preview = session.motion().rotations
    assert session.edits == (EveryNth(8),) and not session.is_thorough
    session.release()
    assert session.edits == (EveryNth(8), Style("*Arm", alpha=6.0)) and session.is_thorough
    np.testing.assert_allclose(session.motion().rotations, preview, atol=1e-8)
    session.drag(Style("*Arm", alpha=1.0))
    session.cancel()
    assert session.metric.parameters.alpha.tolist() == pytest.approx([1.0, 6.0, 6.0])


def test_an_edit_that_does_not_fit_changes_nothing(session):
    before = shown(session)
    for edit in (Style("tail", alpha=2.0), KeepOnly((0.0, 3.5)), Mirror("hips"), ChooseKeys(50)):
        with pytest.raises(ToolError):
            session.apply(EveryNth(3), edit)
    assert shown(session) == before and not session.can_undo


def test_the_ends_stay_keys(session):
    session.apply(KeepOnly((7.0,)), FreeKey(0.0))
    assert session.keys.tolist() == [0.0, 7.0, 39.0]


def test_mirrored_joints_get_what_their_counterparts_have(session):
    session.apply(Style("*LeftArm", alpha=3.0, beta=0.5, invariance="right", tension=0.2), Mirror("*Left*"))
    parameters = session.metric.parameters
    assert parameters.alpha.tolist() == [1.0, 3.0, 3.0] and parameters.invariance[2] == "right"
    assert session.metric.tension.tolist() == [1.0, 0.2, 0.2]


@pytest.mark.parametrize(
    "joint, other",
    [
        ("Hips/LeftUpLeg/LeftLeg", "Hips/RightUpLeg/RightLeg"),
        ("root/arm_r/hand_r", "root/arm_l/hand_l"),
        ("hips/L_Hand1", "hips/R_Hand1"),
        ("mixamorig:RightArm", "mixamorig:LeftArm"),
        ("hips/tail", "hips/tail"),
        ("all/Lower", "all/Lower"),
        ("arm.L", "arm.R"),
    ],
)
def test_counterparts_by_name(joint, other):
    assert counterpart(joint) == other and counterpart(other) == joint


def test_a_session_replayed_from_json_saves_the_same_bytes(session, tmp_path):
    for edit in EDITS.values():
        session.apply(edit)
    session.apply(UseScheme("geodesic-spline"), Style("*", alpha=0.1 + 0.2))
    again = EditSession.open(session.path)
    again.replay(session.to_json())
    assert shown(again) == shown(session) and again.to_json() == session.to_json()
    for content in ("metric", "keys", "dense"):
        options = SaveOptions(content=content)
        one = session.save(tmp_path / "one.usda", options).path.read_bytes()
        assert again.save(tmp_path / "one.usda", options).path.read_bytes() == one


def test_a_session_of_another_file_is_refused(session, tmp_path):
    session.apply(EveryNth(4))
    make_rig(tmp_path / "other.usda", range(9), random_rotations(9, 3, seed=1), joints=JOINTS)
    other = EditSession.open(tmp_path / "other.usda")
    with pytest.raises(ToolError, match="clip.usda"):
        other.replay(session.to_json())
    assert other.edits == ()


@pytest.mark.parametrize("name", EDITS)
def test_edits_survive_json(name):
    document = json.loads(json.dumps(as_dict(EDITS[name])))
    assert as_dict(from_dict(document)) == document
    if name != "metric":
        assert from_dict(document) == EDITS[name]


@pytest.mark.parametrize(
    "document",
    [
        7,
        {},
        {"edit": "explode"},
        {"edit": "style"},
        {"edit": "style", "pattern": "*", "alpha": -1},
        {"edit": "style", "pattern": "*", "alpha": [1]},
        {"edit": "style", "pattern": "*", "colour": "red"},
        {"edit": "style", "pattern": "*", "axes": [1, 2]},
        {"edit": "scheme", "scheme": "bezier"},
        {"edit": "every-nth", "n": 0},
        {"edit": "every-nth", "n": "x"},
        {"edit": "keep-only", "codes": ["x"]},
        {"edit": "keep-only", "codes": 3},
        {"edit": "choose-keys", "count": 1e400},
        {"edit": "metric", "metric": {"format": "other"}},
        {"edit": "pin-key"},
        {"edit": "reset", "pattern": 3},
        {"edit": "pin-key", "code": "x"},
    ],
    ids=str,
)
def test_strange_edits_are_refused_with_a_sentence(document):
    with pytest.raises(ToolError):
        from_dict(document)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "geomstatsAnimSession", "version": 9}', "\x00"])
def test_strange_sessions_are_refused_with_a_sentence(session, text):
    with pytest.raises(ToolError):
        session.replay(text)


def test_saved_metric_is_the_one_that_upsample_reads(session, tmp_path, run):
    session.apply(Style("*Arm", alpha=3.0), Style("hips", tension=0.25))
    result = session.save(tmp_path / "out.usda")
    assert result.path == tmp_path / "out.usda"
    written = EditSession.open(tmp_path / "out.usda").metric
    assert written.provenance == {"styles": ["hips:tension=0.25", "LeftArm:alpha=3", "RightArm:alpha=3"]}
    assert replace(written, provenance={}).to_json() == session.metric.to_json()
    assert run("inspect", tmp_path / "out.usda")[0] == 0
    assert bits(read(tmp_path / "out.usda")[1]) == bits(read(session.path)[1])


def test_saved_keys_rebuild_what_was_shown(session, tmp_path, run):
    session.apply(EveryNth(5), Style("*Arm", alpha=3.0))
    session.save(tmp_path / "keys.usda", SaveOptions(content="keys"))
    assert read(tmp_path / "keys.usda")[0] == session.keys.tolist()
    assert run("upsample", tmp_path / "keys.usda", "-o", tmp_path / "back.usda", "--times", "source")[0] == 0
    session.save(tmp_path / "dense.usda", SaveOptions(content="dense"))
    codes, values = read(tmp_path / "dense.usda")
    assert bits(read(tmp_path / "back.usda")[1]) == bits(values)
    shown = session.motion().rotations[:, session.clip.columns]
    assert codes == session.codes.tolist()
    np.testing.assert_allclose(np.abs((np.array(values) * shown).sum(axis=-1)), 1.0, atol=1e-6)


@pytest.mark.parametrize("scheme", OWN_SCHEMES)
def test_the_command_of_a_stored_metric_names_any_scheme(session, tmp_path, run, monkeypatch, scheme):
    monkeypatch.chdir(tmp_path)
    session.apply(Style("hips", alpha=2.0, tension=0.25), UseScheme(scheme))
    (command,) = session.save("out.usda").commands
    assert run("metric", *shlex.split(command)[3:])[0] == 0
    written = EditSession.open("out.usda").metric
    assert written.scheme == scheme
    if scheme in WITH_METRIC:
        np.testing.assert_array_equal(written.parameters.alpha, session.metric.parameters.alpha)
        np.testing.assert_array_equal(written.tension, session.metric.tension)


@pytest.mark.parametrize("content", CONTENTS)
@pytest.mark.parametrize("keys", [1, 6])
def test_the_commands_that_a_save_names_make_the_same(session, tmp_path, run, monkeypatch, content, keys):
    monkeypatch.chdir(tmp_path)
    session.apply(EveryNth(keys), Style("*Arm", alpha=1.0 / 3.0, axes=(5.0, 0.0, 0.0)), Style("hips", tension=0.1))
    result = session.save("out.usda", SaveOptions(content=content))
    codes, values = read("out.usda")
    assert len(result.commands) == (2 if keys > 1 and content != "metric" else 1)
    for command in result.commands:
        python, dash, module, *words = shlex.split(command)
        assert (python, dash) == ("python", "-m")
        assert run(module.removeprefix("usd_tools."), *words)[0] == 0
    assert read("out.usda")[0] == codes and bits(read("out.usda")[1]) == bits(values)
    one, other = EditSession.open("out.usda").metric, session.metric
    for name in ("alpha", "beta", "axes", "invariance"):
        np.testing.assert_array_equal(getattr(one.parameters, name), getattr(other.parameters, name))
    np.testing.assert_array_equal(one.tension, other.tension)


def test_a_metric_is_learned_for_the_keys_as_one_edit(session):
    session.apply(EveryNth(6))
    before = session.errors().degrees.mean()
    told = []
    session.learn(lambda done, total, text: told.append(done))
    assert session.errors().degrees.mean() < before and told
    assert isinstance(session.edits[-1], UseMetric)
    session.undo()
    assert session.errors().degrees.mean() == before


def test_learning_can_be_cancelled(session):
    class Cancelled(Exception):
        pass

    def cancel(done, total, text):
        raise Cancelled

    session.apply(EveryNth(6))
    with pytest.raises(Cancelled):
        session.learn(cancel)
    assert session.edits == (EveryNth(6),)


def test_presets_apply_and_are_read_from_a_folder(session, tmp_path):
    session.apply(EveryNth(8))
    for name, edits in PRESETS.items():
        session.apply(*edits)
        write_preset(tmp_path / f"{name}.json", edits)
    assert read_presets(tmp_path) == PRESETS
    session.apply(*PRESETS["slerp"])
    np.testing.assert_allclose(session.motion().rotations, session.motion("slerp").rotations, atol=1e-12)
    (tmp_path / "broken.json").write_text("{}")
    with pytest.raises(ToolError, match="broken"):
        read_presets(tmp_path)


def test_sparse_files_are_shown_at_whole_frames(tmp_path):
    make_rig(tmp_path / "sparse.usda", [0, 10, 20], random_rotations(3, 3), joints=JOINTS)
    session = EditSession.open(tmp_path / "sparse.usda")
    assert session.codes.tolist() == list(range(21)) and session.samples.tolist() == [0.0, 10.0, 20.0]
    assert session.errors().frames.tolist() == [0, 10, 20]
    assert session.errors().degrees.max() < 1e-12


def test_blocked_samples_and_cuts_part_the_motion(tmp_path):
    values = [*random_rotations(30, 3, size=0.2)]
    values[10] = None
    make_rig(tmp_path / "blocked.usda", range(30), values, None, joints=JOINTS)
    session = EditSession.open(tmp_path / "blocked.usda")
    session.apply(EveryNth(40))
    assert session.keys.tolist() == [0.0, 9.0, 10.0, 11.0, 29.0]
    assert 10.0 not in session.codes and np.isfinite(session.poses()).all()


def test_a_joint_is_named_exactly():
    assert Style(exactly("a[0]/b*"), alpha=2.0).matches("a[0]/b*")
    assert not Style(exactly("a[0]/b*"), alpha=2.0).matches("a0/bc")


@pytest.mark.parametrize("broken", ["nothing", "several"])
def test_files_that_cannot_be_edited_get_a_sentence(tmp_path, broken):
    stage = make_rig(tmp_path / "clip.usda", [0], random_rotations(1, 3), None)
    if broken == "several":
        for name in ("/Rig/One", "/Rig/Two"):
            stage.DefinePrim(name, "SkelAnimation")
        stage.GetPrimAtPath("/Rig/Skel").RemoveProperty("skel:animationSource")
        stage.Save()
    with pytest.raises(ToolError, match="--prim" if broken == "several" else "moves"):
        EditSession.open(tmp_path / "clip.usda")


def test_the_world_is_that_of_the_stage(tmp_path):
    stage = make_rig(tmp_path / "clip.usda", range(5), random_rotations(5, 3), joints=JOINTS)
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp().Set((0.0, 0.0, 500.0))
    stage.Save()
    session = EditSession.open(tmp_path / "clip.usda", ANIMATION)
    moved = session.poses("original")[:, 0, :, 3] - session.motion("original").translations[:, 0]
    np.testing.assert_allclose(moved, np.tile([0.0, 0.0, 5.0], (5, 1)), atol=1e-12)


@pytest.mark.parametrize("scheme", ["bezier", "", "learned"])
def test_a_metric_of_a_scheme_that_a_session_does_not_have_is_refused(session, scheme):
    with pytest.raises(ToolError, match="needs a library" if scheme == "learned" else "cannot be used"):
        session.apply(UseMetric(LearnedMetric.plain(JOINTS, scheme)))


def test_a_stored_metric_of_other_joints_is_told(tmp_path, session):
    session.apply(UseMetric(LearnedMetric.plain(JOINTS, "geodesic-spline", tension=0.5)))
    session.save(tmp_path / "out.usda")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.GetAttribute("geodesicMetric:joints").Set([*JOINTS[:2], "tail"])
    stage.Save()
    again = EditSession.open(tmp_path / "out.usda")
    assert any("RightArm" in sentence for sentence in again.warnings)
    assert again.metric.tension.tolist() == [0.5, 0.5, 1.0]


def test_edits_are_saved_beside_the_output(session, tmp_path):
    session.apply(EveryNth(4), Style("hips", alpha=2.0))
    path = autosave_path(tmp_path / "out.usda")
    write_session(path, session.to_json())
    assert path.parent == tmp_path and path.name == "out.usda.edits.json"
    again = EditSession.open(session.path)
    again.replay(read_session(path))
    assert again.edits == session.edits
    with pytest.raises(ToolError, match="none.json"):
        read_session(tmp_path / "none.json")


def test_previews_leave_nothing_behind(session):
    session.apply(EveryNth(9))
    start = {name: getattr(session.motion(), name).copy() for name in ("rotations", "translations")}
    poses, errors = session.poses().copy(), session.errors().centimetres.copy()
    for joint in ("hips", "*LeftArm", "*RightArm"):
        for value in (2.0, 4.0):
            session.drag(Style(joint, alpha=value, translation_tension=0.2))
            session.poses()
    other = EditSession.open(session.path)
    other.apply(EveryNth(9), Style("*RightArm", alpha=4.0, translation_tension=0.2))
    np.testing.assert_allclose(session.poses(), other.poses(), atol=1e-9)
    np.testing.assert_allclose(session.errors().degrees, other.errors().degrees, atol=1e-6)
    session.cancel()
    np.testing.assert_array_equal(session.poses(), poses)
    np.testing.assert_array_equal(session.errors().centimetres, errors)
    for name, values in start.items():
        np.testing.assert_array_equal(getattr(session.motion(), name), values)


def test_angles_are_those_from_the_rest_pose(session):
    session.apply(EveryNth(7))
    for name in ("ours", "original", "slerp"):
        turns = quat.distance(session.motion(name).rotations[:, 1], session.skeleton.rest_rotations[1])
        np.testing.assert_array_equal(session.angles(name, 1), np.degrees(turns))
