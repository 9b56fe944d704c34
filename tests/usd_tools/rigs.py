"""Small stages to try things on."""

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel, Vt
from scipy.spatial.transform import Rotation

from geomstats_anim import LearnedMetric, MetricParameters
from usd_tools.metrics.attributes import read_metric
from usd_tools.skel.channels import CHANNELS

JOINTS = ["hips", "hips/spine", "hips/spine/arm"]
SKELETON, ANIMATION = "/Rig/Skel", "/Rig/Anim"

PROVENANCE = {
    "source": "walk.usda",
    "seed": 3,
    "big": 2**40,
    "score": 0.1,
    "done": True,
    "names": ["a", "b"],
    "rates": [0.3, 1.0],
    "counts": [1, 2],
    "none": [],
    "scores": {"left": 0.25},
    "keys": [5],
}


def random_rotations(n_frames, n_joints, seed=0, size=0.5):
    """Quaternions (x, y, z, w) of a smooth motion about several axes, float32."""
    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0.0, 6.0, (2, 1, n_joints, 3))
    turns = size * np.sin(speed * np.arange(n_frames)[:, None, None] / 3.0 + phase)
    return Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(n_frames, n_joints, 4).astype(np.float32)


def set_samples(stage, name, codes, values, path=ANIMATION):
    """Author samples; None is a value block."""
    attribute = stage.GetPrimAtPath(path).GetAttribute(name)
    for code, value in zip(codes, values, strict=True):
        block = value is None
        attribute.Set(Sdf.ValueBlock() if block else CHANNELS[name].to_usd(np.asarray(value)), float(code))


def make_rig(
    path,
    codes=(0, 1, 2, 3),
    rotations=None,
    translations="moving",
    scales="ones",
    joints=JOINTS,
    anim_joints=None,
    rate=24.0,
    bind=True,
):
    """Write a file with one skeleton and one animation, and return its stage."""
    anim_joints = list(joints) if anim_joints is None else anim_joints
    n_joints = len(anim_joints)
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(UsdSkel.Root.Define(stage, "/Rig").GetPrim())
    stage.SetTimeCodesPerSecond(rate)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, "Z")
    skeleton = UsdSkel.Skeleton.Define(stage, SKELETON)
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[:, 3, :3] = [0.0, 10.0, 0.0]
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray.FromNumpy(rest))
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray.FromNumpy(rest))
    animation = UsdSkel.Animation.Define(stage, ANIMATION)
    animation.CreateJointsAttr(anim_joints)
    if bind:
        UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([ANIMATION])
    rotations = random_rotations(len(codes), n_joints) if rotations is None else rotations
    set_samples(stage, "rotations", codes, rotations)
    if isinstance(translations, str):
        translations = np.linspace(0, 1, len(codes) * n_joints * 3, dtype=np.float32).reshape(-1, n_joints, 3) + 10
    if translations is not None:
        set_samples(stage, "translations", codes, translations)
    if isinstance(scales, str):
        animation.CreateScalesAttr(Vt.Vec3hArray.FromNumpy(np.ones((n_joints, 3), dtype=np.float16)))
    elif scales is not None:
        set_samples(stage, "scales", codes, scales)
    stage.GetRootLayer().Save()
    return stage


def read(path, name="rotations", prim=ANIMATION):
    """Time codes and values of an attribute, None where it is blocked."""
    stage = Usd.Stage.Open(str(path))
    attribute = stage.GetPrimAtPath(prim).GetAttribute(name)
    codes = attribute.GetTimeSamples()
    values = [attribute.Get(code) for code in codes]
    return codes, [None if value is None else CHANNELS[name].to_numpy(value) for value in values]


def some_metric(axes=False, joints=JOINTS):
    """Return a metric with other numbers everywhere, and provenance."""
    rng = np.random.default_rng(0)
    n = len(joints)
    parameters = MetricParameters(
        rng.uniform(0.1, 9.0, n),
        rng.uniform(0.1, 9.0, n),
        rng.normal(size=(n, 3)) if axes else None,
        tuple(rng.choice(["left", "right"], n)),
    )
    return LearnedMetric(
        tuple(joints), parameters, rng.uniform(size=n), "geodesic", "hyb", PROVENANCE, rng.uniform(size=n)
    )


def stored_metric(path):
    """Metric of a file's animation."""
    stage = Usd.Stage.Open(str(path))
    return read_metric(stage.GetPrimAtPath(ANIMATION))


def bits(values):
    """Comparable bytes of arrays, so that nothing is equal that is not identical."""
    return [None if value is None else value.tobytes() for value in values]
