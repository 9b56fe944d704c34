"""A character in a USD file or on a stage: one SkelRoot with its skeletons' joints and their motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel, Vt

from geomstats_anim import Skeleton
from usd_tools.skel.channels import CHANNELS, Channel, write_samples
from usd_tools.skel.skeleton import BONE_ENDS
from usd_tools.skel.writer import AnimationLayer

ROOT = Sdf.Path("/Character")
SKELETON, ANIMATION = (ROOT.AppendChild(name) for name in ("Skeleton", "Animation"))
"""Files of one rig have the same paths, whatever their names: then they can be layered and learned from together."""

_CHUNK = 1 << 15
"""Joints that are placed at once: enough to keep NumPy busy, few enough to need little memory."""


@dataclass(frozen=True)
class Units:
    """Units and axes of the numbers of a character.

    Parameters
    ----------
    metres : float
        Metres per unit of length.
    up : str
        "Y" or "Z".
    frames_per_second : float
        Frames, which are time codes, per second.
    """

    metres: float
    up: str
    frames_per_second: float


def new_stage(character: Character) -> Usd.Stage:
    """Make a stage in memory with nothing but a character, its units, and its frames as time codes."""
    units = character.units
    stage = Usd.Stage.Open(Sdf.Layer.CreateAnonymous(".usda"))
    UsdGeom.SetStageUpAxis(stage, units.up)
    UsdGeom.SetStageMetersPerUnit(stage, units.metres)
    stage.SetTimeCodesPerSecond(units.frames_per_second)
    stage.SetFramesPerSecond(units.frames_per_second)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(character.rotations) - 1)
    stage.SetDefaultPrim(add_character(stage, character, AnimationLayer(stage.GetRootLayer(), Sdf.LayerOffset())))
    return stage


@dataclass(frozen=True, eq=False)
class Character:
    """A skeleton and its motion, a pose per frame.

    Parameters
    ----------
    skeleton : Skeleton
    names : sequence of str, shape=[B]
        Names of the joints to show to people.
    rotations : array-like, shape=[F, B, 4]
        Relative to the parent, unit quaternions (x, y, z, w).
    translations : array-like, shape=[F, B, 3]
        Relative to the parent.
    units : Units
    """

    skeleton: Skeleton
    names: Sequence[str]
    rotations: np.ndarray
    translations: np.ndarray
    units: Units

    def bounds(self) -> np.ndarray:
        """Return the lowest and the highest coordinates of all joints and bone ends, shape=[2, 3]."""
        ends = np.concatenate([self.skeleton.bone_ends, np.ones((self.skeleton.n_joints, 1))], axis=1)[:, None]
        extremes = []
        step = max(1, _CHUNK // self.skeleton.n_joints)
        for start in range(0, len(self.rotations), step):
            matrices = self._joint_matrices(slice(start, start + step))
            for points in (matrices[..., 3, :3], (ends @ matrices)[..., 0, :3]):
                extremes += [points.min(axis=0), points.max(axis=0)]  # frame by frame is fast, joint by joint is not
        points = np.concatenate(extremes)
        return np.array([points.min(axis=0), points.max(axis=0)])

    def height_metres(self) -> float:
        """Return how far it is from the lowest to the highest point of the skeleton at rest."""
        up = "XYZ".index(self.units.up)
        heights = self.skeleton.rest_translations[:, up].copy()
        for joint, parent in enumerate(self.skeleton.parents):
            if parent >= 0:
                heights[joint] += heights[parent]
        points = np.concatenate([heights, heights + self.skeleton.bone_ends[:, up]])
        return float(np.ptp(points)) * self.units.metres

    def _joint_matrices(self, frames: slice) -> np.ndarray:
        """Return the joints' transforms to the SkelRoot, as OpenUSD computes them, shape=[F, B, 4, 4]."""
        rotations, translations = (
            values[frames].astype(np.float32).reshape(-1, values.shape[-1])
            for values in (self.rotations, self.translations)
        )
        scales = np.ones(translations.shape, dtype=np.float16)
        local = UsdSkel.MakeTransforms(
            CHANNELS["translations"].to_usd(translations),
            CHANNELS["rotations"].to_usd(rotations),
            CHANNELS["scales"].to_usd(scales),
        )
        first = np.arange(0, len(translations), self.skeleton.n_joints)[:, None]
        parents = np.where(self.skeleton.parents < 0, -1, first + self.skeleton.parents)
        topology = UsdSkel.Topology(Vt.IntArray.FromNumpy(parents.astype(np.int32).ravel()))
        return np.array(UsdSkel.ConcatJointTransforms(topology, local)).reshape(-1, self.skeleton.n_joints, 4, 4)


def add_character(stage: Usd.Stage, character: Character, layer: AnimationLayer) -> Usd.Prim:
    """Write a skeleton and its motion into the edit target of a stage.

    Every frame is a sample, from time code 0 on. Translations are samples only where one of them changes: what is
    constant is one value. Where the stage has another unit, up axis or rate, the SkelRoot is scaled and turned, and the
    samples are as many seconds apart.

    Parameters
    ----------
    stage : Usd.Stage
    character : Character
    layer : AnimationLayer
        That of the edit target.

    Returns
    -------
    root : Usd.Prim
        SkelRoot of a new name, with a Skeleton and a SkelAnimation.
    """
    path, number = ROOT, 0
    while stage.GetPrimAtPath(path):
        number += 1
        path = Sdf.Path(f"{ROOT}_{number}")
    root = UsdSkel.Root.Define(stage, path)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    _fit(root, character.units)
    root.CreateExtentAttr(_float3(character.bounds()))
    _add_skeleton(stage, path, character)
    _add_animation(stage, path, character, layer)
    return root.GetPrim()


def _fit(root: UsdSkel.Root, units: Units) -> None:
    """Turn and scale a character to the up axis and the unit of its stage, where they differ from its own."""
    stage = root.GetPrim().GetStage()
    if UsdGeom.GetStageUpAxis(stage) != units.up:
        root.AddRotateXOp().Set(90.0 if units.up == "Y" else -90.0)
    scale = units.metres / UsdGeom.GetStageMetersPerUnit(stage)
    if scale != 1.0:
        root.AddScaleOp().Set((scale, scale, scale))


def _float3(values: np.ndarray) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.asarray(values, dtype=np.float32))


def _matrices(translations: np.ndarray) -> Vt.Matrix4dArray:
    """Make transforms that do not turn; USD's vectors are rows."""
    matrices = np.tile(np.eye(4), (len(translations), 1, 1))
    matrices[:, 3, :3] = translations
    return Vt.Matrix4dArray.FromNumpy(matrices)


def _add_skeleton(stage: Usd.Stage, root: Sdf.Path, character: Character) -> None:
    rest = character.skeleton
    places = rest.rest_translations.copy()
    for joint, parent in enumerate(rest.parents):
        if parent >= 0:
            places[joint] += places[parent]
    skeleton = UsdSkel.Skeleton.Define(stage, root.AppendChild(SKELETON.name))
    skeleton.CreateJointsAttr(rest.joints)
    skeleton.CreateJointNamesAttr(character.names)
    skeleton.CreateBindTransformsAttr(_matrices(places))
    skeleton.CreateRestTransformsAttr(_matrices(rest.rest_translations))
    ends = skeleton.GetPrim().CreateAttribute(BONE_ENDS, Sdf.ValueTypeNames.Double3Array, custom=True)
    ends.Set(Vt.Vec3dArray.FromNumpy(rest.bone_ends))
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([root.AppendChild(ANIMATION.name)])


def _add_animation(stage: Usd.Stage, root: Sdf.Path, character: Character, layer: AnimationLayer) -> None:
    path = root.AppendChild(ANIMATION.name)
    prim = UsdSkel.Animation.Define(stage, path)
    prim.CreateJointsAttr(character.skeleton.joints)
    prim.CreateScalesAttr(CHANNELS["scales"].to_usd(np.ones((character.skeleton.n_joints, 3), dtype=np.float16)))
    translations = character.translations.astype(np.float32)
    prim.CreateRotationsAttr()
    samples = {"rotations": character.rotations.astype(np.float32)}
    if (translations == translations[0]).all():
        prim.CreateTranslationsAttr(_float3(translations[0]))
    else:
        prim.CreateTranslationsAttr()
        samples["translations"] = translations
    codes = np.arange(len(translations)) * (stage.GetTimeCodesPerSecond() / character.units.frames_per_second)
    for name, values in samples.items():
        channel = Channel(name, codes, values, np.zeros(len(codes), dtype=bool), values[0], "")
        write_samples(layer.prim(path).attributes[name], channel, layer.offset)
