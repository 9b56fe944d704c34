"""What learn makes: a metric that upsample finds, the same bytes each time, and an honest account of it."""

import hashlib
import json
import shlex
import sys

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel
from real_files import CLIPS, real_file
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples, stored_metric

from geomstats_anim import LearnedMetric
from geomstats_anim import rotations as quat
from geomstats_anim.rotations import distance
from usd_tools.console.progress import SearchProgress
from usd_tools.console.tables import show
from usd_tools.learning.clips import training_clip, with_joint_order
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

CODES = range(20)


def make_clip(path, seed=0, joints=JOINTS, **rest):
    """A file in which every joint turns about several axes."""
    return make_rig(
        path, codes=CODES, rotations=random_rotations(20, len(joints), seed, size=0.4), joints=joints, **rest
    )


@pytest.fixture
def clip(tmp_path):
    make_clip(tmp_path / "in.usda")
    return tmp_path / "in.usda"


@pytest.fixture
def learned(tmp_path, run):
    """Learn and give stdout, stderr and the report."""

    def call(*arguments):
        code, out, err = run("learn", *arguments, "--report", tmp_path / "report.json")
        assert code == 0, err
        return out, err, json.loads((tmp_path / "report.json").read_text())

    return call


def test_layer_holds_the_metric_and_leaves_samples_alone(tmp_path, clip, learned, run):
    before = clip.read_bytes()
    learned(clip, "-o", tmp_path / "out.usda")
    assert clip.read_bytes() == before
    assert bits(read(tmp_path / "out.usda")[1]) == bits(read(clip)[1])
    over = Sdf.Layer.FindOrOpen(str(tmp_path / "out.usda"))
    assert list(over.subLayerPaths) == ["./in.usda"]
    assert not over.GetAttributeAtPath(f"{ANIMATION}.rotations")
    metric = stored_metric(tmp_path / "out.usda")
    assert (metric.joints, metric.scheme, metric.quality) == (tuple(JOINTS), "geodesic-spline", "hyb")
    code, out, _ = run("upsample", tmp_path / "out.usda", "-o", tmp_path / "up.usda", "--factor", 2)
    assert code == 0 and "geodesic-spline, stored metric" in out
    run("upsample", clip, "-o", tmp_path / "slerp.usda", "--factor", 2)
    bent, flat = (np.array(read(tmp_path / name)[1], dtype=np.float64) for name in ("up.usda", "slerp.usda"))
    assert distance(bent, flat)[1::2].max() > 1e-3


def test_provenance(tmp_path, clip, learned):
    out, _, report = learned(
        clip, "-o", tmp_path / "out.usda", "--rate", 0.4, "--purpose", "predict", "--seed", 3, "--weights", "depth"
    )
    provenance = stored_metric(tmp_path / "out.usda").provenance
    assert provenance["source"] == "in.usda"
    assert provenance["sha256"] == hashlib.sha256(clip.read_bytes()).hexdigest()
    told = {
        "rate": 0.4,
        "search": "gradient",
        "purpose": "predict",
        "family": "diagonal",
        "seed": 3,
        "weights": "depth",
    }
    assert {name: provenance[name] for name in told} == told
    assert provenance["evaluations"] > 0 and provenance["version"]
    assert provenance["score"] <= provenance["slerp_score"] * 1.005
    assert provenance["by_joint"]["joints"] == JOINTS
    assert len(provenance["by_joint"]["shrinkage"]) == 3
    assert len(provenance["out_of_sample"]["scores"]) == len(provenance["out_of_sample"]["what"]) > 0
    assert str(tmp_path) not in (tmp_path / "out.usda").read_text()
    metric = stored_metric(tmp_path / "out.usda")
    tie = all((values == 1.0).all() for values in (metric.parameters.moments, metric.tension))
    assert ("A tie with the plain spline" in out) == tie and ("Cross-validated: it predicts" in out) == (not tie)
    assert report["metrics"][0]["scores"][0]["verdict"] != "loses to slerp"


@pytest.mark.parametrize("name", ["out.usda", "out.json", "out.usdc"])
def test_same_input_same_bytes(tmp_path, clip, learned, name):
    contents = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        learned(clip, "-o", tmp_path / folder / name)
        contents.append([(tmp_path / folder / name).read_bytes(), (tmp_path / "report.json").read_bytes()])
        clip.touch()
    assert contents[0] == contents[1]


def test_json_and_layer_hold_the_same_metric(tmp_path, clip, learned, run):
    learned(clip, "-o", tmp_path / "out.usda", "--family", "spd")
    learned(clip, "-o", tmp_path / "out.json", "--family", "spd")
    stored = stored_metric(tmp_path / "out.usda")
    assert json.loads(stored.to_json()) == json.loads((tmp_path / "out.json").read_text())
    for name, metric in (("a.usda", "stored"), ("b.usda", tmp_path / "out.json")):
        run("upsample", tmp_path / "out.usda", "-o", tmp_path / name, "--factor", 2, "--metric", metric)
    assert bits(read(tmp_path / "a.usda")[1]) == bits(read(tmp_path / "b.usda")[1])


def test_report_and_table_are_honest(tmp_path, clip, learned):
    out, _, report = learned(clip, "-o", tmp_path / "out.usda")
    (metric,) = report["metrics"]
    first, *others = metric["scores"]
    assert first["in_sample"] and first["verdict"] == "beats slerp"
    assert others and not any(score["in_sample"] for score in others)
    for score in metric["scores"]:
        assert score["gain"] == pytest.approx(1 - score["score"] / score["slerp_score"])
        assert score["verdict"] in out and score["what"] in out
    loses = any(score["verdict"] == "loses to slerp" for score in others)
    assert loses and metric["conclusion"] in out and "use --purpose predict" in metric["conclusion"]
    for joint in metric["joints"]:
        assert joint["gain"] == pytest.approx(joint["slerp_error"] - joint["error"], abs=1e-4)
        assert joint["alpha"] > 0 and joint["beta"] > 0 and joint["invariance"] in ("left", "right")
    assert report["output"] == "out.usda" and report["settings"]["rate"] == 0.3


def test_each_animation_gets_its_own_metric(tmp_path, learned):
    stage = make_clip(tmp_path / "in.usda")
    other = UsdSkel.Animation.Define(stage, "/Rig/Other")
    other.CreateJointsAttr(JOINTS)
    set_samples(stage, "rotations", CODES, random_rotations(20, 3, seed=5, size=0.4), "/Rig/Other")
    stage.Save()
    _, _, report = learned(tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    assert [metric["animations"][0]["prim"] for metric in report["metrics"]] == [ANIMATION, "/Rig/Other"]
    _, _, report = learned(tmp_path / "in.usda", "-o", tmp_path / "one.usda", "--prim", "/Rig/Other")
    assert [metric["animations"][0]["prim"] for metric in report["metrics"]] == ["/Rig/Other"]
    assert stored_metric(tmp_path / "one.usda") is None
    _, _, report = learned(tmp_path / "in.usda", "-o", tmp_path / "all.json")
    assert len(report["metrics"]) == 1 and len(report["metrics"][0]["animations"]) == 2


def test_in_place_and_flatten(tmp_path, clip, learned):
    samples = bits(read(clip)[1])
    learned(clip, "-o", tmp_path / "flat.usda", "--flatten")
    assert not Sdf.Layer.FindOrOpen(str(tmp_path / "flat.usda")).subLayerPaths
    learned(clip, "--in-place")
    for name in ("flat.usda", "in.usda"):
        assert stored_metric(tmp_path / name).quality == "hyb"
        assert bits(read(tmp_path / name)[1]) == samples


@pytest.mark.parametrize("bound", ["inside", "outside"])
def test_instances_keep_their_samples(tmp_path, learned, bound):
    make_clip(tmp_path / "rig.usda", bind=bound == "inside")
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/{name}")
        prim.GetReferences().AddReference("./rig.usda")
        prim.SetInstanceable(True)
        if bound == "outside":
            UsdSkel.BindingAPI.Apply(prim).CreateAnimationSourceRel().SetTargets([f"/{name}/Anim"])
    stage.Save()
    learned(tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    clips = [read_clip(source) for source in find_animations(out)]
    driving = [clip for clip in clips if clip.source.skeletons]
    assert driving
    for clip in driving:
        assert clip.source.prim.HasAttribute("geodesicMetric:alpha")
        assert bits(clip.channels["rotations"].values) == bits(read(tmp_path / "rig.usda")[1])


def test_corpus_of_files_and_folders(tmp_path, learned, run):
    (tmp_path / "takes" / "more").mkdir(parents=True)
    make_clip(tmp_path / "walk.usda")
    make_clip(tmp_path / "takes" / "run.usda", seed=1)
    make_clip(tmp_path / "takes" / "more" / "jump.usdc", seed=2, joints=JOINTS)
    run("upsample", tmp_path / "walk.usda", "-o", tmp_path / "takes" / "walk_x2.usda", "--factor", 2)
    (tmp_path / "takes" / "notes.txt").write_text("hello")
    (tmp_path / "takes" / "broken.usda").write_text("hello")
    out, err, report = learned(tmp_path / "walk.usda", tmp_path / "takes", "-o", tmp_path / "hero.json")
    assert [one["file"] for one in report["metrics"][0]["animations"]] == ["walk.usda", "jump.usdc", "run.usda"]
    assert [one["file"] for one in report["skipped"]] == ["broken.usda"]
    assert "warning: skipped: " in err and "walk_x2.usda was written by this package" in err
    metric = LearnedMetric.from_json((tmp_path / "hero.json").read_text())
    assert metric.provenance["source"] == ["walk.usda", "jump.usdc", "run.usda"]
    assert len(metric.provenance["sha256"]) == 3 and metric.provenance["frames"] == [20, 20, 20]
    assert "3 animations" in out
    told = ["--factor", 2, "--metric", tmp_path / "hero.json"]
    assert run("upsample", tmp_path / "walk.usda", "-o", tmp_path / "out.usda", *told)[0] == 0


def test_joints_are_matched_by_name(tmp_path, learned):
    make_clip(tmp_path / "a.usda")
    rotations = random_rotations(20, 3, size=0.4)
    shuffled = ["hips/spine/arm", "hips", "hips/spine"]
    make_rig(tmp_path / "b.usda", codes=CODES, rotations=rotations[:, [2, 0, 1]], anim_joints=shuffled, joints=shuffled)
    takes = []
    for name in ("a.usda", "b.usda"):
        (source,) = find_animations(Usd.Stage.Open(str(tmp_path / name)))
        takes.append(training_clip(tmp_path / name, read_clip(source)))
    first, second = (with_joint_order(take, JOINTS).stretches[0] for take in takes)
    assert first.skeleton.joints == second.skeleton.joints == tuple(JOINTS)
    np.testing.assert_array_equal(first.rotations, second.rotations)
    np.testing.assert_array_equal(first.skeleton.parents, second.skeleton.parents)
    _, _, report = learned(tmp_path / "a.usda", tmp_path / "b.usda", "-o", tmp_path / "ab.json")
    _, _, alone = learned(tmp_path / "a.usda", "-o", tmp_path / "a.json", "--kind", "rot")
    assert len(report["metrics"][0]["animations"]) == 2 and len(alone["metrics"][0]["joints"]) == 3


def test_blocks_and_steps_cut(tmp_path):
    codes = [*range(10), 10 - Usd.TimeCode.SafeStep(), *range(10, 20)]
    rotations = list(random_rotations(21, 3, size=1.0))
    rotations[4] = None
    make_rig(tmp_path / "in.usda", codes=codes, rotations=rotations, translations=None)
    (source,) = find_animations(Usd.Stage.Open(str(tmp_path / "in.usda")))
    take = training_clip(tmp_path / "in.usda", read_clip(source))
    seconds = [(stretch.times[[0, -1]] * 24).round(4).tolist() for stretch in take.stretches]
    assert seconds == [[0, 3], [5, 10], [10, 19]]
    assert [stretch.n_frames for stretch in take.stretches] == [4, 6, 10]


def test_samples_of_other_channels_are_not_taken_for_motion(tmp_path):
    stage = make_clip(tmp_path / "in.usda", translations=None)
    denser = np.arange(0, 19.5, 0.5)
    set_samples(stage, "translations", denser, np.float32(np.random.default_rng(0).normal(size=(len(denser), 3, 3))))
    (source,) = find_animations(stage)
    (stretch,) = training_clip(tmp_path / "in.usda", read_clip(source)).stretches
    assert stretch.n_frames == 20


def test_upsample_learns_from_the_clip_itself(tmp_path, clip, run):
    code, out, err = run("upsample", clip, "-o", tmp_path / "out.usda", "--factor", 2, "--metric", "learn")
    assert (code, err) == (0, "")
    metric = stored_metric(tmp_path / "out.usda")
    assert (metric.provenance["purpose"], metric.provenance["rate"]) == ("predict", 0.5)
    ours, *others = (metric.provenance[f"cross_validated_{name}score"] for name in ("", "slerp_", "plain_"))
    if ours == others[1]:
        assert "a tie, and it is kept" in out
    else:
        gain = 100.0 * (1.0 - ours / min(others))
        word = "better" if gain >= 0.0 else "worse"
        assert f"cross-validated, it predicts the others {abs(gain):.1f} % {word} than" in out


def test_upsample_says_when_there_is_nothing_to_learn(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=(0, 1, 2))
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "o.usda", "--factor", 2, "--metric", "learn")
    assert code == 0
    assert err == (
        f"warning: {tmp_path}/in.usda: {ANIMATION} has 3 samples, too few to learn from; at least 4 are needed; "
        "using the identity.\n"
    )


def test_tensions_are_learned_stored_and_used(tmp_path, clip, learned, run):
    out, _, report = learned(clip, "-o", tmp_path / "out.usda", "--scheme", "geodesic-spline", "--rate", 0.4)
    assert "plain spline" in out
    metric = stored_metric(tmp_path / "out.usda")
    assert metric.scheme == "geodesic-spline"
    (told,) = report["metrics"]
    assert [joint["tension"] for joint in told["joints"]] == metric.tension.tolist()
    assert [joint["translation_tension"] for joint in told["joints"]] == metric.translation_tension.tolist()
    assert told["scores"][0]["score"] <= min(told["scores"][0]["slerp_score"], told["scores"][0]["plain_score"])
    code, out, _ = run("upsample", tmp_path / "out.usda", "-o", tmp_path / "up.usda", "--factor", 2)
    assert code == 0 and "geodesic-spline, stored metric" in out
    np.testing.assert_array_equal(stored_metric(tmp_path / "up.usda").tension, metric.tension)


def test_inspect_tells_what_the_metric_means(tmp_path, clip, learned, run, inspected):
    learned(clip, "-o", tmp_path / "out.usda", "--family", "spd")
    (animation,) = inspected(tmp_path / "out.usda")["animations"]
    rows = animation["metric"]["by_joint"]
    gains = [row["gain"] for row in rows if row["matters"]]
    assert gains and gains == sorted(gains, reverse=True)
    assert {row["joint"] for row in rows} == set(JOINTS)
    _, out, _ = run("inspect", tmp_path / "out.usda")
    assert "gain over slerp" in out and "In-sample: +" in out and "Out-of-sample, learned on the first half" in out
    assert any(word in out for word in ("own (left)", "parent (right)"))


@pytest.mark.slow
@pytest.mark.parametrize("name", CLIPS)
@pytest.mark.parametrize("purpose", ["reconstruct", "predict"])
def test_real_clips(tmp_path, learned, run, name, purpose):
    # what halves of these short clips teach a spline is judged in learning/test_never_worse.py
    scheme = ["--scheme", "geodesic"] if purpose == "predict" else []
    _, err, report = learned(real_file(name), "-o", tmp_path / "out.usda", "--purpose", purpose, *scheme)
    assert err == ""
    scores = report["metrics"][0]["scores"]
    if purpose == "reconstruct":
        assert scores[0]["verdict"] in ("beats the plain spline", "beats slerp")
    else:
        assert all(score["score"] < 1.005 * score["slerp_score"] for score in scores)
    code, out, _ = run("upsample", tmp_path / "out.usda", "-o", tmp_path / "up.usda", "--factor", 2)
    assert code == 0 and "stored metric" in out


def test_skeletons_carry_the_summary(tmp_path, clip, learned):
    learned(clip, "-o", tmp_path / "out.usda")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    skeleton = stage.GetPrimAtPath(SKELETON)
    assert skeleton.GetAttribute("userProperties:geodesicMetricSummary").Get().startswith("geodesic-spline, 3 joints")


@pytest.mark.parametrize("width", [60, 80, 200])
def test_tables_lose_nothing_on_a_narrow_terminal(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    row = ("learned at rate 0.3, scored at rate 0.45", "out-of-sample", "0.13038", "-23.5 %")
    show("Q", [row], ("", "frames", "learned", "gain"))
    out = capsys.readouterr().out
    assert max(len(line) for line in out.splitlines() if "\x1b" not in line) <= width
    for word in ("learned", "0.45", "out-of-sample", "0.13038", "-23.5"):
        assert word in out


def test_progress_tells_evaluations_value_and_gain(monkeypatch):
    told = []
    progress = SearchProgress(None, None)
    monkeypatch.setattr(progress, "advance", lambda amount, words: told.append((amount, words)))
    progress.choose(0.4)
    for evaluations, value in ((1, 2.0), (5, 1.5), (1, 4.0), (3, 3.0)):
        progress.watch(evaluations, value)
    assert told == [
        (0.0, "Choosing keys: 40%"),
        (1, "Learning: 1 tried, Q 2, 0.0 % below slerp"),
        (4, "Learning: 5 tried, Q 1.5, 25.0 % below slerp"),
        (1, "Checking what carries over, 1: 1 tried, Q 4, 0.0 % below slerp"),
        (2, "Checking what carries over, 1: 3 tried, Q 3, 25.0 % below slerp"),
    ]


@pytest.mark.parametrize(("search", "trials"), [("tpe", 25), ("tpe-joint", 6)])
@pytest.mark.slow
def test_tpe_searches(tmp_path, clip, learned, search, trials):
    pytest.importorskip("ray")
    pytest.importorskip("hyperopt")
    told = ["--search", search, "--trials", trials]
    _, _, report = learned(clip, "-o", tmp_path / "out.usda", *told)
    provenance = stored_metric(tmp_path / "out.usda").provenance
    assert provenance["search"] == search and provenance["score"] <= provenance["plain_score"]
    if search == "tpe-joint":
        learned(clip, "-o", tmp_path / "a.usda", *told, "--folder", tmp_path / "runs")
        _, _, again = learned(clip, "-o", tmp_path / "b.usda", *told, "--resume", tmp_path / "runs")
        assert again["metrics"][0]["scores"][0] == report["metrics"][0]["scores"][0]


def test_the_command_for_a_metric_can_be_pasted(tmp_path, clip, learned):
    there = tmp_path / "out dir" / "hero's.json"
    there.parent.mkdir()
    out = learned(clip, "-o", there)[0]
    command = out.partition("Use it with:\n")[2].splitlines()[0]
    assert shlex.split(command)[-2:] == ["--metric", str(there)]


def test_a_scheme_that_loses_to_what_upsample_does_alone_says_so(tmp_path, learned):
    """A smooth motion: geodesics jump in velocity where the plain spline does not."""
    t = np.linspace(0.0, 6.0, 61)[:, None, None] * np.array([1.0, 1.3, 0.7])[:, None]
    vectors = np.concatenate([np.sin(t), np.cos(1.7 * t), 0.5 * np.sin(2.3 * t)], axis=-1)
    rotations = quat.exp(vectors).astype(np.float32)
    make_rig(tmp_path / "in.usda", codes=range(61), rotations=rotations, translations=None)
    out, _, report = learned(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--scheme", "geodesic")
    score = report["metrics"][0]["scores"][0]
    assert score["plain_score"] < score["score"] <= score["slerp_score"] * 1.001
    assert score["verdict"] == "loses to the plain spline"
    assert "Without a metric, upsample uses the plain spline, which is better: use --scheme geodesic-spline." in out
    out, _, report = learned(tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    score = report["metrics"][0]["scores"][0]
    assert score["score"] <= score["plain_score"] and "Without a metric" not in out
