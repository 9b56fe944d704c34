"""Verbs as functions: on files, and on open stages through their edit targets; they print nothing."""

import dataclasses
import os
import stat

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples

from usd_tools.console.errors import ToolError, UsageError
from usd_tools.downsample import DownsampleOptions, downsample, downsample_stage
from usd_tools.inspect import inspect, inspect_stage
from usd_tools.learn import LearnOptions, learn, learn_stage
from usd_tools.metrics.attributes import read_metric
from usd_tools.upsample import Style, UpsampleOptions, upsample, upsample_stage

CODES = tuple(range(12))


@pytest.fixture(autouse=True)
def silent(capfd):
    yield
    assert capfd.readouterr() == ("", "")


def shown(stage, name="rotations", path=ANIMATION):
    """Time codes and values of an attribute as the stage shows them."""
    attribute = stage.GetPrimAtPath(path).GetAttribute(name)
    return attribute.GetTimeSamples(), [np.array(attribute.Get(code)) for code in attribute.GetTimeSamples()]


def session_layer(stage):
    stage.SetEditTarget(stage.GetSessionLayer())


def root_layer(stage):
    stage.SetEditTarget(stage.GetRootLayer())


def target_of(stage):
    return stage.GetEditTarget().GetLayer()


@pytest.mark.parametrize("target", [session_layer, root_layer])
def test_upsample_stage_is_upsample(tmp_path, target):
    make_rig(tmp_path / "in.usda", codes=CODES)
    options = UpsampleOptions(factor=3, alpha=4.0, joint="arm:beta=2")
    upsample(tmp_path / "in.usda", tmp_path / "out.usda", options)
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    target(stage)
    result = upsample_stage(stage, options)
    codes, values = read(tmp_path / "out.usda")
    assert shown(stage)[0] == codes and bits(shown(stage)[1]) == bits([np.array(each) for each in values])
    assert target_of(stage).ListTimeSamplesForPath(f"{ANIMATION}.rotations") == codes
    assert result.path is None and result.output == target_of(stage).GetDisplayName()
    assert read_metric(stage.GetPrimAtPath(ANIMATION)).parameters.beta.tolist() == [1.0, 1.0, 2.0]
    assert "timeCodesPerSecond" not in stage.GetSessionLayer().pseudoRoot.ListInfoKeys()


@pytest.mark.parametrize("given_offset", [True, False])
def test_a_sublayer_with_an_offset(tmp_path, given_offset):
    make_rig(tmp_path / "in.usda", codes=CODES)
    below = Sdf.Layer.CreateNew(str(tmp_path / "over.usda"))
    root = Sdf.Layer.CreateNew(str(tmp_path / "root.usda"))
    root.subLayerPaths = ["./over.usda", "./in.usda"]
    root.subLayerOffsets[0] = Sdf.LayerOffset(10.0, 2.0)
    root.defaultPrim = "Rig"
    stage = Usd.Stage.Open(root)
    before = shown(stage)
    stage.SetEditTarget(stage.GetEditTargetForLocalLayer(below) if given_offset else Usd.EditTarget(below))
    upsample_stage(stage, UpsampleOptions(factor=2))
    codes, values = shown(stage)
    assert codes == np.arange(0.0, 11.5, 0.5).tolist()
    assert bits(values[::2]) == bits(before[1])
    assert below.ListTimeSamplesForPath(f"{ANIMATION}.rotations") == [(code - 10.0) / 2.0 for code in codes]


def test_inside_a_variant(tmp_path):
    stage = make_rig(tmp_path / "in.usda", codes=CODES)
    layer = stage.GetRootLayer()
    sets = stage.GetPrimAtPath("/Rig").GetVariantSets().AddVariantSet("take")
    for name in ("walk", "run"):
        sets.AddVariant(name)
    sets.SetVariantSelection("run")
    # The samples move into both variants, so that nothing local hides them.
    for name in ("walk", "run"):
        Sdf.CopySpec(layer, ANIMATION, layer, f"/Rig{{take={name}}}Anim")
    del layer.GetPrimAtPath("/Rig").nameChildren["Anim"]
    walk = layer.ListTimeSamplesForPath("/Rig{take=walk}Anim.rotations")
    with sets.GetVariantEditContext():
        upsample_stage(stage, UpsampleOptions(factor=2))
    assert layer.ListTimeSamplesForPath("/Rig{take=run}Anim.rotations") == np.arange(0.0, 11.5, 0.5).tolist()
    assert layer.ListTimeSamplesForPath("/Rig{take=walk}Anim.rotations") == walk
    assert shown(stage)[0] == np.arange(0.0, 11.5, 0.5).tolist()


def test_what_would_be_hidden_is_refused_and_undone(tmp_path):
    make_rig(tmp_path / "in.usda", codes=CODES)
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    strong = stage.GetSessionLayer()
    strong.TransferContent(stage.GetRootLayer())
    before = stage.GetRootLayer().ExportToString()
    for call in (
        lambda: upsample_stage(stage, UpsampleOptions(factor=2)),
        lambda: downsample_stage(stage, DownsampleOptions(rate=0.5)),
    ):
        with pytest.raises(ToolError, match="would be hidden by .*; choose a stronger edit target"):
            call()
        assert stage.GetRootLayer().ExportToString() == before
    # A metric is hidden by nothing.
    learn_stage(stage, LearnOptions(rate=0.5))
    assert read_metric(stage.GetPrimAtPath(ANIMATION)) is not None


def test_a_target_that_cannot_hold_it(tmp_path):
    make_rig(tmp_path / "in.usda", codes=CODES)
    stage = Usd.Stage.CreateNew(str(tmp_path / "root.usda"))
    for name in ("/A", "/B"):
        stage.DefinePrim(name).GetReferences().AddReference("./in.usda", "/Rig")
    node = stage.GetPrimAtPath("/A").GetPrimIndex().rootNode.children[0]
    referenced = node.layerStack.identifier.rootLayer
    stage.SetEditTarget(Usd.EditTarget(referenced, node))
    before = referenced.ExportToString()
    with pytest.raises(ToolError, match="cannot hold /B/Anim; choose another"):
        upsample_stage(stage, UpsampleOptions(factor=2))
    assert referenced.ExportToString() == before
    upsample_stage(stage, UpsampleOptions(factor=2, prim="/A"))
    assert shown(stage, path="/A/Anim")[0] == shown(stage, path="/B/Anim")[0] == np.arange(0.0, 11.5, 0.5).tolist()
    stage.SetEditTarget(stage.GetRootLayer())
    stage.GetRootLayer().SetPermissionToEdit(False)
    with pytest.raises(ToolError, match="may not be edited"):
        upsample_stage(stage, UpsampleOptions(factor=2))


def test_a_stage_in_memory_learns_and_is_downsampled():
    stage = Usd.Stage.CreateInMemory()
    skeleton = UsdSkel.Skeleton.Define(stage, SKELETON)
    skeleton.CreateJointsAttr(JOINTS)
    animation = UsdSkel.Animation.Define(stage, ANIMATION)
    animation.CreateJointsAttr(JOINTS)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([ANIMATION])
    animation.CreateRotationsAttr(), animation.CreateTranslationsAttr()
    set_samples(stage, "rotations", range(24), random_rotations(24, 3))
    set_samples(stage, "translations", [0], [np.full((3, 3), 2.0)])
    before = shown(stage)
    stage.SetEditTarget(stage.GetSessionLayer())
    learned = learn_stage(stage)
    assert learned.metrics[0].metric == learned.metrics[0].metric and len(learned.metrics[0].provenance["sha256"]) == 64
    done = downsample_stage(stage, DownsampleOptions(tolerance=5.0))
    (only,) = done.animations
    assert shown(stage)[0] == list(only.kept_time_codes) and only.kept_samples < 24
    kept = [before[0].index(code) for code in only.kept_time_codes]
    assert bits(shown(stage)[1]) == bits([before[1][k] for k in kept])
    upsample_stage(stage, UpsampleOptions(times="source"))
    assert shown(stage)[0] == before[0]
    assert stage.GetRootLayer().ListTimeSamplesForPath(f"{ANIMATION}.rotations") == before[0]


def test_functions_on_files_hand_back_what_the_report_holds(tmp_path):
    make_rig(tmp_path / "in.usda", codes=CODES)
    told, steps = [], []
    up = upsample(
        str(tmp_path / "in.usda"),
        tmp_path / "up.usda",
        UpsampleOptions(fps=60, report=tmp_path / "up.json"),
        progress=lambda done, total, text: steps.append((done, total, text)),
        warn=told.append,
    )
    assert up.path == tmp_path / "up.usda" and tuple(told) == up.warnings
    assert steps[-1][0] == pytest.approx(steps[-1][1]) and steps[-1][2] == "Interpolating"
    down = downsample(tmp_path / "in.usda", tmp_path / "down.usdc", DownsampleOptions(keys=6))
    assert down.animations[0].kept_samples == 6 and down.file_bytes_after == (tmp_path / "down.usdc").stat().st_size
    learned = learn([tmp_path / "in.usda"], tmp_path / "rig.json", LearnOptions(rate=0.5))
    assert learned.metrics[0].metric.joints == tuple(JOINTS)
    for result in (up, down, learned):
        assert set(result.as_dict()) >= {"tool", "version", "output", "settings", "warnings"}
    import json

    assert json.loads((tmp_path / "up.json").read_text()) == json.loads(json.dumps(up.as_dict()))


def test_options_are_checked_wherever_they_come_from(tmp_path):
    for options, words, sentence in (
        (UpsampleOptions, {}, "name exactly one of --factor, --fps and --times, not none"),
        (
            UpsampleOptions,
            {"factor": 2, "fps": 3},
            "not factor and fps",
        ),
        (UpsampleOptions, {"factor": 0}, "--factor must be a whole number of at least 1, not 0"),
        (UpsampleOptions, {"factor": 2.5}, "--factor must be a whole number of at least 1, not 2.5"),
        (UpsampleOptions, {"factor": 2, "retime": True}, "--retime needs --fps"),
        (UpsampleOptions, {"factor": 2, "scheme": "slurp"}, "--scheme must be .*; did you mean slerp"),
        (UpsampleOptions, {"factor": 2, "alpha": -1.0}, "--alpha must be a positive number, not -1.0"),
        (UpsampleOptions, {"times": [1, float("nan")]}, "--times must be comma-separated numbers"),
        (UpsampleOptions, {"factor": 2, "usd_format": "usdz"}, "--usdFormat must be usda or usdc, not 'usdz'"),
        (DownsampleOptions, {}, "name exactly one of --rate, --keys, --tolerance and --keep-only, not none"),
        (DownsampleOptions, {"rate": 1.0}, "--rate must be a number above 0 and below 1, not 1.0"),
        (DownsampleOptions, {"tolerance": 1, "kind": "rot"}, "--kind rot needs --rate or --keys"),
        (LearnOptions, {"search": "tpe", "folder": "x"}, "--folder goes with --search tpe-joint"),
        (LearnOptions, {"seed": -1}, "--seed must be a whole number of at least 0, not -1"),
    ):
        with pytest.raises(UsageError, match=sentence):
            options(**words)
    options = UpsampleOptions(times=[1, 2.5], joint=["a:alpha=2", Style("b", beta=3.0)], prim="/A")
    assert options.settings() == {"times": "1,2.5", "joint": "a:alpha=2 b:beta=3", "prim": "/A"}
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.factor = 3
    with pytest.raises(UsageError, match="name the output"):
        upsample(tmp_path / "in.usda", None, UpsampleOptions(factor=2))
    with pytest.raises(UsageError, match="an open stage keeps its rate"):
        upsample_stage(Usd.Stage.CreateInMemory(), UpsampleOptions(fps=30, retime=True))


def test_downsample_verifies_before_it_replaces(tmp_path, monkeypatch):
    """What is read back from the file is off: the older file stays."""
    make_rig(tmp_path / "in.usda", codes=range(24))
    (tmp_path / "out.usdc").write_bytes(b"older")
    import usd_tools.downsampling.reduce as reduce

    def damaged(source):
        clip = reduce_read(source)
        channel = clip.channels["translations"]
        return dataclasses.replace(
            clip, channels={**clip.channels, "translations": dataclasses.replace(channel, values=channel.values + 9.0)}
        )

    reduce_read = reduce.read_clip
    monkeypatch.setattr(reduce, "read_clip", damaged)
    for out, options in ((tmp_path / "out.usdc", {}), (None, {"in_place": True})):
        before = {path: path.read_bytes() for path in tmp_path.iterdir()}
        with pytest.raises(ToolError, match="is rebuilt only to within .* cm"):
            downsample(tmp_path / "in.usda", out, DownsampleOptions(tolerance=1.0, **options))
        assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.skipif(os.name == "nt", reason="no modes on Windows")
def test_replaced_files_keep_their_mode(tmp_path):
    make_rig(tmp_path / "in.usda", codes=CODES)
    (tmp_path / "out.usda").write_text("older")
    for path, mode in ((tmp_path / "in.usda", 0o640), (tmp_path / "out.usda", 0o664)):
        path.chmod(mode)
    upsample(tmp_path / "in.usda", tmp_path / "out.usda", UpsampleOptions(factor=2))
    upsample(tmp_path / "in.usda", None, UpsampleOptions(factor=2, in_place=True, report=tmp_path / "new.json"))
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    mask = os.umask(0)
    os.umask(mask)
    assert modes == {"in.usda": 0o640, "out.usda": 0o664, "new.json": 0o666 & ~mask}
    if os.geteuid() == 0:
        os.chown(tmp_path / "out.usda", 12345, 23456)
        upsample(tmp_path / "in.usda", tmp_path / "out.usda", UpsampleOptions(factor=2))
        owner = (tmp_path / "out.usda").stat()
        assert (owner.st_uid, owner.st_gid) == (12345, 23456)


def test_inspect_is_the_same_for_a_file_and_its_stage(tmp_path):
    make_rig(tmp_path / "in.usda", codes=CODES, bind=False)
    told = []
    result = inspect(tmp_path / "in.usda", warn=told.append)
    assert tuple(told) == result.warnings and result.animations[0]["samples"] == 12
    assert inspect_stage(Usd.Stage.Open(str(tmp_path / "in.usda"))) == result
    stage = Usd.Stage.CreateInMemory()
    assert inspect_stage(stage).animations == ()
