"""A new UsdSkel file of one skeleton and its motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel, Vt

from geomstats_anim import Animation
from geomstats_anim.kinematics import world_pose
from usd_tools.skel.channels import CHANNELS
from usd_tools.skel.skeleton import BONE_ENDS

ROOT = Sdf.Path("/Character")
SKELETON, ANIMATION = (ROOT.AppendChild(name) for name in ("Skeleton", "Animation"))
"""Files of one rig have the same paths, whatever their names: then they can be layered and learned from together."""


@dataclass(frozen=True)
class Units:
    """What a file says of its numbers.

    Parameters
    ----------
    metres : float
        Metres for one unit of length.
    up : str
        "Y" or "Z".
    frames_per_second : float
        Frames, which are time codes, a second.
    """

    metres: float
    up: str
    frames_per_second: float


def new_layer(animation: Animation, names: list[str], units: Units) -> Sdf.Layer:
    """Write a skeleton and its motion into a new layer.

    Every frame is a sample, from time code 0 on. Translations are samples only where one of them changes: what is
    constant is one value.

    Parameters
    ----------
    animation : Animation
        Lengths in the file's unit, times in frames.
    names : list of str, shape=[B]
        Names of the joints to show to people.
    units : Units

    Returns
    -------
    layer : Sdf.Layer
        In memory: SkelRoot, Skeleton and SkelAnimation.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, units.up)
    UsdGeom.SetStageMetersPerUnit(stage, units.metres)
    stage.SetTimeCodesPerSecond(units.frames_per_second)
    stage.SetFramesPerSecond(units.frames_per_second)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(animation.n_frames - 1)
    root = UsdSkel.Root.Define(stage, ROOT)
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    pose = world_pose(animation)
    points = np.concatenate([pose.origins, pose.ends], axis=1)
    root.CreateExtentAttr(_float3([points.min(axis=(0, 1)), points.max(axis=(0, 1))]))
    _add_skeleton(stage, animation, names)
    _add_animation(stage, animation)
    return layer


def _float3(values: np.ndarray | list[np.ndarray]) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.asarray(values, dtype=np.float32))


def _matrices(translations: np.ndarray) -> Vt.Matrix4dArray:
    """Make transforms that do not turn; USD's vectors are rows."""
    matrices = np.tile(np.eye(4), (len(translations), 1, 1))
    matrices[:, 3, :3] = translations
    return Vt.Matrix4dArray.FromNumpy(matrices)


def _add_skeleton(stage: Usd.Stage, animation: Animation, names: list[str]) -> None:
    rest = animation.skeleton
    places = rest.rest_translations.copy()
    for joint, parent in enumerate(rest.parents):
        if parent >= 0:
            places[joint] += places[parent]
    skeleton = UsdSkel.Skeleton.Define(stage, SKELETON)
    skeleton.CreateJointsAttr(rest.joints)
    skeleton.CreateJointNamesAttr(names)
    skeleton.CreateBindTransformsAttr(_matrices(places))
    skeleton.CreateRestTransformsAttr(_matrices(rest.rest_translations))
    ends = skeleton.GetPrim().CreateAttribute(BONE_ENDS, Sdf.ValueTypeNames.Double3Array, custom=True)
    ends.Set(Vt.Vec3dArray.FromNumpy(rest.bone_ends))
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([ANIMATION])


def _add_animation(stage: Usd.Stage, animation: Animation) -> None:
    prim = UsdSkel.Animation.Define(stage, ANIMATION)
    prim.CreateJointsAttr(animation.skeleton.joints)
    prim.CreateScalesAttr(CHANNELS["scales"].to_usd(np.ones((animation.n_joints, 3), dtype=np.float16)))
    translations = animation.translations.astype(np.float32)
    samples = {"rotations": animation.rotations.astype(np.float32)}
    if (translations == translations[0]).all():
        prim.CreateTranslationsAttr(_float3(translations[0]))
    else:
        samples["translations"] = translations
    for name, values in samples.items():
        kind = CHANNELS[name]
        attribute = prim.GetPrim().CreateAttribute(name, kind.value_type, custom=False)
        with Sdf.ChangeBlock():
            for frame, value in enumerate(values):
                stage.GetRootLayer().SetTimeSample(attribute.GetPath(), frame, kind.to_usd(value))
