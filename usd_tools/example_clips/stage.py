"""The clips as UsdSkel: skeleton, animation, skin and ground on a stage."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdSkel, Vt

from usd_tools.example_clips.biped import NAMES, OFFSETS, forward_kinematics, joint_paths, rest_positions
from usd_tools.example_clips.body import Skin, deform
from usd_tools.example_clips.posing import RATE, Motion

_DIGITS = 5  # of quaternions and metres: a hundredth of a millimetre, and compact text
_COLORS = ((0.78, 0.74, 0.66), (0.28, 0.52, 0.74), (0.86, 0.47, 0.32))  # trunk, left, right
_GROUND, _BOX = (0.55, 0.56, 0.58), (0.42, 0.44, 0.48)


def _rounded(values: ArrayLike) -> np.ndarray:
    """Round to what the file holds, without negative zeros."""
    return (np.round(np.asarray(values, dtype=float), _DIGITS) + 0.0).astype(np.float32)


def _vectors(values: ArrayLike) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(_rounded(values))


def _integers(values: np.ndarray) -> Vt.IntArray:
    return Vt.IntArray.FromNumpy(values.astype(np.int32).ravel())


def _add_skeleton(stage: Usd.Stage, path: Sdf.Path, animation: Sdf.Path) -> None:
    skeleton = UsdSkel.Skeleton.Define(stage, path)
    skeleton.CreatePurposeAttr(UsdGeom.Tokens.guide)
    skeleton.CreateJointsAttr(joint_paths())
    for create, places in (
        (skeleton.CreateBindTransformsAttr, rest_positions()),
        (skeleton.CreateRestTransformsAttr, OFFSETS),
    ):
        create([Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*place)) for place in np.round(places, _DIGITS).tolist()])
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation])


def _add_animation(stage: Usd.Stage, path: Sdf.Path, motion: Motion) -> None:
    animation = UsdSkel.Animation.Define(stage, path)
    animation.CreateJointsAttr(joint_paths())
    animation.CreateScalesAttr(Vt.Vec3hArray(len(NAMES), Gf.Vec3h(1.0)))
    rotations, translations = animation.CreateRotationsAttr(), animation.CreateTranslationsAttr()
    places = OFFSETS.copy()
    for frame, (quats, hips) in enumerate(zip(motion.rotations, motion.hips, strict=True)):
        places[0] = hips
        rotations.Set(Vt.QuatfArray.FromNumpy(_rounded(quats)), frame)
        translations.Set(_vectors(places), frame)


def _add_skin(stage: Usd.Stage, path: Sdf.Path, skeleton: Sdf.Path, skin: Skin) -> None:
    mesh = UsdGeom.Mesh.Define(stage, path)
    points = _vectors(skin.points)
    mesh.CreatePointsAttr(points)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateFaceVertexCountsAttr([4] * len(skin.quads))
    mesh.CreateFaceVertexIndicesAttr(_integers(skin.quads))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.catmullClark)

    side = np.array([1 if name.startswith("Left") else 2 if name.startswith("Right") else 0 for name in NAMES])
    colors = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    colors.Set(Vt.Vec3fArray(_COLORS))
    colors.SetIndices(_integers(side[skin.joints[:, 0]]))  # the first joint weighs most

    weights = np.round(skin.weights, 3)
    weights[:, 0] = 1.0 - weights[:, 1:].sum(axis=1)
    influences = weights.shape[1]
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton])
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    binding.CreateJointIndicesPrimvar(False, influences).Set(_integers(skin.joints))
    binding.CreateJointWeightsPrimvar(False, influences).Set(Vt.FloatArray.FromNumpy(_rounded(weights).ravel()))


def _add_surroundings(stage: Usd.Stage, root: Sdf.Path, motion: Motion) -> None:
    (west, _, north), (east, _, south) = motion.hips.min(axis=0) - 1.5, motion.hips.max(axis=0) + 1.5
    ground = UsdGeom.Mesh.Define(stage, root.AppendChild("Ground"))
    corners = _vectors([(west, 0.0, north), (west, 0.0, south), (east, 0.0, south), (east, 0.0, north)])
    ground.CreatePointsAttr(corners)
    ground.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(corners))
    ground.CreateFaceVertexCountsAttr([4])
    ground.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    ground.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    ground.CreateDisplayColorAttr([_GROUND])
    if motion.box is not None:
        low, high = np.array(motion.box)
        box = UsdGeom.Cube.Define(stage, root.AppendChild("Box"))
        box.CreateSizeAttr(1.0)
        box.CreateExtentAttr([(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)])
        box.AddTranslateOp().Set(Gf.Vec3d(*np.round(0.5 * (low + high), _DIGITS).tolist()))
        box.AddScaleOp().Set(Gf.Vec3f(*np.round(high - low, _DIGITS).tolist()))
        box.CreateDisplayColorAttr([_BOX])


def make_stage(motion: Motion, skin: Skin) -> Usd.Stage:
    """Make a clip of a motion.

    Parameters
    ----------
    motion : Motion
        The samples.
    skin : Skin
        The mesh at rest and its weights.

    Returns
    -------
    stage : Usd.Stage
        The clip, in memory: y up, metres, time codes from 0.
    """
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(RATE)
    stage.SetFramesPerSecond(RATE)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(motion.hips) - 1)
    stage.GetRootLayer().customLayerData = {"creator": "examples/make_clips.py"}
    world = UsdGeom.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(world.GetPrim())
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)

    biped = UsdSkel.Root.Define(stage, "/World/Biped")
    Usd.ModelAPI(biped).SetKind(Kind.Tokens.component)
    points = deform(skin, *forward_kinematics(motion.rotations, motion.hips))
    biped.CreateExtentAttr(_vectors([points.min(axis=(0, 1)), points.max(axis=(0, 1))]))
    skeleton, animation, mesh = (biped.GetPath().AppendChild(name) for name in ("Skeleton", "Animation", "Skin"))
    _add_skeleton(stage, skeleton, animation)
    _add_animation(stage, animation, motion)
    _add_skin(stage, mesh, skeleton, skin)
    _add_surroundings(stage, world.GetPath(), motion)
    return stage
