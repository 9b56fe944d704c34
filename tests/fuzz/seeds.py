"""Small good files to begin from, each with something else in it."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdSkel, UsdUtils

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "usd_tools"))

from bvh_files import CHAIN, MIXED, write_bvh  # noqa: E402
from rigs import ANIMATION, JOINTS, SKELETON, make_rig, random_rotations, set_samples  # noqa: E402

from geomstats_anim import LearnedMetric, MetricParameters  # noqa: E402
from geomstats_anim.learning.tune.journal import Journal  # noqa: E402
from geomstats_anim.learning.tune.tpe import Space  # noqa: E402
from usd_tools.metrics.attributes import write_metric  # noqa: E402

SPACE = Space(range(2), "spd", "joint", "geodesic-spline")


def seeds() -> dict[str, list[bytes]]:
    """Contents of the files, by their extensions."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        texts = [make(folder / f"{k}.usda") for k, make in enumerate(_USD)]
        for text in texts:
            layer = Sdf.Layer.FindOrOpen(str(text))
            layer.Export(str(text.with_suffix(".usdc")))
            UsdUtils.CreateNewUsdzPackage(str(text.with_suffix(".usdc")), str(text.with_suffix(".usdz")))
        found = {suffix: [text.with_suffix(suffix).read_bytes() for text in texts] for suffix in (".usdc", ".usdz")}
        found[".usda"] = [text.read_bytes() for text in texts]
        for k, text in enumerate((MIXED, CHAIN)):
            write_bvh(folder / f"{k}.bvh", n_frames=3, text=text)
        found[".bvh"] = [(folder / f"{k}.bvh").read_bytes() for k in range(2)]
        found[".json"] = [_metric().to_json().encode(), _metric().to_json().replace("\n", "").encode()]
        found[".txt"] = [b"0.5, 1.25\n3\n", b"# no comment\n1 2 2.5", b"source"]
        found[".jsonl"] = [_journal(folder / "trials.jsonl")]
    return found


def _metric() -> LearnedMetric:
    parameters = MetricParameters([4.0, 1.0, 2.0], [0.5, 1.0, 1.0], np.eye(3), ("left", "right", "left"))
    provenance = {"source": "a.usda", "seed": 3, "styles": ["*:alpha=2"], "scores": {"left": [0.25, None]}}
    return LearnedMetric(tuple(JOINTS), parameters, np.ones(3), "geodesic-spline", "hyb", provenance)


def _journal(path: Path) -> bytes:
    journal = Journal(path)
    journal.begin(SPACE, 3, resume=False)
    for k in range(4):
        journal.add({**SPACE.identity, "log_alpha_0": 0.1 * k, "side_1": "right"}, 0.5 - 0.1 * k)
    return path.read_bytes()


def _moving(path: Path) -> Path:
    make_rig(path, codes=range(10), rotations=random_rotations(10, 3)).GetRootLayer()
    return path


def _everything_in_a_channel(path: Path) -> Path:
    poses = list(random_rotations(6, 2))
    poses[3] = None
    scales = np.float16([[[1, 1, 1]] * 2, [[2, 1, 0.5]] * 2])
    codes = (0, 1 - Usd.TimeCode.SafeStep(), 1, 2.5, 4, 7)
    stage = make_rig(
        path, codes, poses, translations=None, scales=None, anim_joints=["hips/spine/arm", "hips"], rate=30
    )
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile", "frown"])
    set_samples(stage, "scales", (0, 7), scales)
    set_samples(stage, "blendShapeWeights", (0, 3), np.float32([[[0], [1]], [[1], [0]]]))
    stage.Save()
    return path


def _with_metric(path: Path) -> Path:
    stage = make_rig(path, codes=range(5), rotations=random_rotations(5, 3))
    joints = tuple(stage.GetPrimAtPath(ANIMATION).GetAttribute("joints").Get())
    parameters = MetricParameters([4.0, 1.0, 2.0], [0.5, 1.0, 1.0], np.eye(3), ("left", "right", "left"))
    provenance = {
        "source": "a.usda",
        "seed": 3,
        "styles": ["*:alpha=2"],
        "score": 0.1,
        "slerp_score": 0.2,
        "plain_score": 0.2,
        "out_of_sample": {"what": ["b"], "scores": [0.3], "slerp_scores": [0.2], "plain_scores": [0.1]},
        "by_joint": {"joints": list(joints), "degrees": [1.0, 2.0, 3.0], "slerp_degrees": [2.0, 2.0, 4.0]},
    }
    metric = LearnedMetric(joints, parameters, np.ones(3), "geodesic-spline", "hyb", provenance)
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), metric)
    stage.Save()
    return path


def _composed(path: Path) -> Path:
    stage = make_rig(path, bind=False)
    root = stage.GetRootLayer()
    Sdf.CreatePrimInLayer(root, "/_class").specifier = Sdf.SpecifierClass
    Sdf.CopySpec(root, "/Rig", root, "/_class/Rig")
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/World/{name}")
        prim.GetReferences().AddInternalReference("/_class/Rig", Sdf.LayerOffset(10.0, 0.5))
        prim.SetInstanceable(True)
    UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/Rig")).CreateAnimationSourceRel().SetTargets([ANIMATION])
    variants = stage.GetPrimAtPath("/Rig").GetVariantSets().AddVariantSet("take")
    variants.AddVariant("one")
    variants.SetVariantSelection("one")
    with variants.GetVariantEditContext():
        set_samples(stage, "rotations", (0, 4), random_rotations(2, 3, seed=5))
    Sdf.CopySpec(root, SKELETON, root, "/Rig/Twin")
    stage.Save()
    return path


_USD = (_moving, _everything_in_a_channel, _with_metric, _composed)
