"""From a USD stage to `Animation`: which animations there are, what they drive, and their samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdSkel, Vt

from geomstats_anim import Animation, Skeleton
from geomstats_anim.animation import default_bone_ends
from geomstats_anim.rotations import IDENTITY, normalize
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import VALUE_CLIPS, Channel, read_channel, step_pairs
from usd_tools.skel.find import AnimationSource, chosen_variants

JOINT_CHANNELS = ("rotations", "translations", "scales")
"""Channels of which every joint has one element."""

BONE_ENDS = "geomstatsAnim:boneEnds"
"""Custom double3[] of a Skeleton: the end of each joint's bone in its own frame, in the file's unit."""


@dataclass(frozen=True, eq=False)
class SkelClip:
    """What a SkelAnimation and its skeleton say.

    Parameters
    ----------
    source : AnimationSource
    skeleton : Skeleton
        All joints of the bound skeleton, then those that only the animation has, parents first; metres.
    joints : tuple of str, shape=[N]
        The animation's joints, in its own order.
    columns : array-like of int, shape=[N]
        Where each of them is in `skeleton`.
    channels : mapping of str to Channel
        What is authored.
    missing : mapping of str to array-like, shape=[N, C]
        Values for channels that are not authored, though others are: without them USD shows the rest pose.
    world_scale : float
        Metres for one unit of the file.
    codes_per_second : float
    notes : tuple of str
        Sentences about what a user should know.
    """

    source: AnimationSource
    skeleton: Skeleton
    joints: tuple[str, ...]
    columns: np.ndarray
    channels: Mapping[str, Channel]
    missing: Mapping[str, np.ndarray]
    world_scale: float
    codes_per_second: float
    notes: tuple[str, ...]

    @property
    def path(self) -> str:
        """Path of the SkelAnimation."""
        return self.source.path

    @property
    def is_animated(self) -> bool:
        """Whether there is anything to interpolate."""
        return any(channel.is_animated for channel in self.channels.values())

    @cached_property
    def codes(self) -> np.ndarray:
        """Time codes of all samples of animated channels, shape=[K], increasing."""
        codes = [channel.codes for channel in self.channels.values() if channel.is_animated]
        return np.unique(np.concatenate(codes)) if codes else np.zeros(0)

    @property
    def steps(self) -> np.ndarray:
        """Which gaps between `codes` are steps and not motion, shape=[K - 1]."""
        return step_pairs(self.codes, self.codes_per_second)

    def keys(self, names: Sequence[str], span: slice) -> Animation:
        """Make an animation of the whole skeleton from the samples of some channels.

        Parameters
        ----------
        names : sequence of str
            Channels that have the same time codes; the others stay at the pose of the first sample.
        span : slice
            Which samples; none of them blocked.

        Returns
        -------
        animation : Animation
            Seconds and metres.

        Raises
        ------
        ToolError
            If a quaternion has no length.
        """
        codes = self.channels[names[0]].codes[span]
        pose = {
            "rotations": self.skeleton.rest_rotations,
            "translations": self.skeleton.rest_translations,
            "scales": np.ones((self.skeleton.n_joints, 3)),
        }
        arrays: dict[str, np.ndarray | None] = {}
        for name, rest in pose.items():
            channel = self.channels.get(name)
            array = np.tile(rest, (len(codes), 1, 1))
            if channel is not None:
                array[:, self.columns] = self._to_metric_units(
                    name, channel.values[span] if name in names else channel.default[None]
                )
            arrays[name] = array
        if "scales" not in self.channels:
            arrays["scales"] = None
        return Animation(self.skeleton, codes / self.codes_per_second, **arrays)  # type: ignore[arg-type]

    def _to_metric_units(self, name: str, values: np.ndarray) -> np.ndarray:
        values = values.astype(np.float64)
        if name == "translations":
            return values * self.world_scale
        if name == "rotations":
            zeros = np.argwhere(np.linalg.norm(values, axis=-1) < 1e-6)
            if len(zeros):
                joint = self.joints[zeros[0][1]]
                raise ToolError(
                    f"{self.path}: a rotation of joint {joint} is a quaternion of length 0; repair the file."
                )
            return normalize(values)
        return values


def read_clip(source: AnimationSource) -> SkelClip:
    """Read an animation and the skeleton it drives.

    Parameters
    ----------
    source : AnimationSource

    Returns
    -------
    clip : SkelClip

    Raises
    ------
    ToolError
        If joints repeat, a value has the wrong size, or a number is not finite.
    """
    prim, stage = source.prim, source.stage
    joints = names_in(prim, "joints")
    if len(set(joints)) != len(joints):
        twice = next(joint for i, joint in enumerate(joints) if joint in joints[:i])
        raise ToolError(f"{source.path}: joint {twice} is in joints twice; repair the file.")
    notes = []
    channels = {}
    for name in JOINT_CHANNELS:
        channel = read_channel(prim, name, len(joints))
        if channel is not None:
            channels[name] = channel
    if not joints and any(channel.is_animated for channel in channels.values()):
        raise ToolError(f"{source.path} has samples, but no joints; author its joints.")
    n_shapes = len(names_in(prim, "blendShapes"))
    try:
        weights = read_channel(prim, "blendShapeWeights", n_shapes) if n_shapes else None
        if weights is not None:
            channels["blendShapeWeights"] = weights
    except ToolError as error:
        # USD holds weights whose number changes; they cannot be interpolated, but need not keep the joints from it.
        notes.append(f"{str(error).removesuffix('; repair the file.')}; the weights are left as they are.")

    rate = stage.GetTimeCodesPerSecond()
    for channel in channels.values():
        _check_times(source.path, channel.codes, rate)
    units = UsdGeom.GetStageMetersPerUnit(stage)
    first_code = min((channel.codes[0] for channel in channels.values() if len(channel.codes)), default=None)
    if len(source.skeletons) > 1:
        source, alike = _largest_first(source, first_code)
        if not alike:
            largest = source.skeletons[0].GetPath()
            notes.append(
                f"{source.path} drives skeletons of different sizes; lengths are those of the largest, {largest}."
            )
    scale = (_world_scale(source.skeletons[0], first_code) if source.skeletons else 1.0) * units
    if not (np.isfinite(scale) and scale > 0.0):
        notes.append(f"{source.path}: {scale:g} is no length for a unit of the file; one metre is taken.")
        scale = 1.0
    try:
        skeleton, columns, has_rest = _skeleton(source, joints, channels, scale)
    except ValueError as error:
        raise ToolError(f"{source.path} has a skeleton that cannot be used: {error}") from error

    missing = {}
    if joints and any(name in channels for name in JOINT_CHANNELS):
        rest = {
            "rotations": skeleton.rest_rotations[columns],
            "translations": skeleton.rest_translations[columns] / scale,
            "scales": np.ones((len(joints), 3)),
        }
        absent = [name for name in JOINT_CHANNELS if name not in channels and not _is_blocked(prim, name)]
        missing = {name: rest[name] for name in absent if name == "scales" or has_rest}
        if absent:
            of = f" of {source.skeletons[0].GetPath()}" if len(source.skeletons) > 1 else ""
            done = f"written from the rest pose{of}" if len(missing) == len(absent) else "not known without a skeleton"
            notes.append(f"{source.path} has no {' and no '.join(absent)}, so viewers show the rest pose; {done}.")
    own = names_in(source.skeletons[0], "joints") if source.skeletons else ()
    if own and joints and not set(own) & set(joints):
        notes.append(
            f"{source.path} has no joint of {source.skeletons[0].GetPath()}, which it drives, so nothing moves in "
            f"viewers; {joints[0]} is none of {', '.join(own[:3])}{'' if len(own) <= 3 else ' and others'}."
        )
    if any(channel.is_animated for channel in channels.values()):
        notes += [
            f"{source.path} is of the variant {variant}; what is written over it hides its other variants."
            for variant in chosen_variants(prim)
        ]
    notes += [
        f"{source.path}: {name} come from value clips; samples in the output hide them."
        for name, channel in channels.items()
        if channel.source == VALUE_CLIPS
    ]
    return SkelClip(
        source,
        skeleton,
        joints,
        columns,
        channels,
        missing,
        scale,
        rate,
        tuple(notes),
    )


def _check_times(path: str, codes: np.ndarray, rate: float) -> None:
    """Refuse times that cannot be computed with."""
    if not (np.isfinite(rate) and rate > 0.0):
        raise ToolError(f"{path}: there are {rate:g} time codes a second on its stage; correct timeCodesPerSecond.")
    with np.errstate(all="ignore"):
        seconds = codes / rate
        bad = ~np.isfinite(seconds) | ~(np.diff(seconds, prepend=-np.inf) > 0.0)
    if bad.any():
        raise ToolError(
            f"{path}: time code {codes[bad][0]:g}, at {rate:g} a second, is no time after the sample before; repair "
            "the file."
        )


def names_in(prim: Usd.Prim, name: str) -> tuple[str, ...]:
    """Read an attribute of tokens; empty if it has no value.

    Raises
    ------
    ToolError
        If it holds something else.
    """
    value = prim.GetAttribute(name).Get()
    if value is not None and not isinstance(value, Vt.TokenArray):
        raise ToolError(f"{prim.GetPath()}: {name} is not of type token[]; repair the file.")
    return tuple(value or ())


def _is_blocked(prim: Usd.Prim, name: str) -> bool:
    """Whether an attribute has no value because its author says so."""
    attribute = prim.GetAttribute(name)
    return bool(attribute) and (attribute.GetNumTimeSamples() > 0 or attribute.GetResolveInfo().ValueIsBlocked())


def _world_scale(skeleton: Usd.Prim, code: float | None) -> float:
    """Geometric mean of a skeleton's scale in the world."""
    time = Usd.TimeCode.EarliestTime() if code is None else Usd.TimeCode(code)
    matrix = UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(time)
    return float(np.cbrt(abs(matrix.GetDeterminant3())))


def _largest_first(source: AnimationSource, code: float | None) -> tuple[AnimationSource, bool]:
    """Put the skeleton with the longest bones first, as errors in it are the largest; and tell if all are alike."""
    scales = np.array([_world_scale(skeleton, code) for skeleton in source.skeletons])
    rests = [_rest_pose(UsdSkel.Skeleton(prim), len(names_in(prim, "joints"))) for prim in source.skeletons]
    bones = [np.nan if rest is None else np.linalg.norm(rest[0], axis=-1).sum() for rest in rests]
    sizes = np.nan_to_num(scales * (np.ones(len(rests)) if np.isnan(bones).any() else bones), posinf=0.0)
    largest = source.skeletons[int(np.argmax(sizes > 0.999 * sizes.max()))]
    others = tuple(prim for prim in source.skeletons if prim != largest)
    return replace(source, skeletons=(largest, *others)), bool(np.allclose(sizes, sizes[0], rtol=1e-3, atol=0.0))


def _skeleton(
    source: AnimationSource, joints: tuple[str, ...], channels: Mapping[str, Channel], scale: float
) -> tuple[Skeleton, np.ndarray, bool]:
    """Skeleton in metres, the place of each joint of the animation in it, and whether a rest pose is authored."""
    bound = UsdSkel.Skeleton(source.skeletons[0]) if source.skeletons else None
    own = names_in(source.skeletons[0], "joints") if bound else ()
    if len(set(own)) != len(own):
        raise ToolError(f"{source.skeletons[0].GetPath()} names a joint twice; repair the file.")
    names = own + tuple(joint for joint in joints if joint not in set(own))
    parents = np.array(UsdSkel.Topology(names).GetParentIndices() if names else [], dtype=np.intp)
    place = {name: i for i, name in enumerate(names)}
    columns = np.array([place[joint] for joint in joints], dtype=np.intp)

    # Joints without a rest pose rest where the animation begins.
    translations, rotations = np.zeros((len(names), 3)), np.tile(IDENTITY, (len(names), 1))
    if "translations" in channels:
        translations[columns] = channels["translations"].default
    if "rotations" in channels:
        default = channels["rotations"].default.astype(np.float64)
        norm = np.linalg.norm(default, axis=-1, keepdims=True)
        rotations[columns] = np.where(norm > 0.0, default / np.where(norm > 0.0, norm, 1.0), IDENTITY)
    rest = _rest_pose(bound, len(own)) if own else None
    if rest is not None:
        translations[: len(own)], rotations[: len(own)] = rest

    order = _parents_first(parents)
    rank = np.argsort(order)
    parents = np.where(parents[order] >= 0, rank[parents[order]], -1) if len(names) else parents
    lengths = _bone_lengths(bound, len(own)) if len(own) else []
    translations = translations[order] * scale
    bone_lengths = [lengths[i] * scale if i < len(lengths) else None for i in order]
    bone_ends = default_bone_ends(parents, translations, bone_lengths)
    authored = _bone_ends(bound, len(own)) if own else None
    if authored is not None:
        bone_ends[rank[: len(own)]] = authored * scale
    skeleton = Skeleton(
        [names[i] for i in order],  # type: ignore[arg-type]
        parents,
        translations,
        rotations[order],
        bone_ends,
    )
    return skeleton, rank[columns], rest is not None and set(joints) <= set(own)


def _parents_first(parents: np.ndarray) -> np.ndarray:
    """Order in which parents come before their children, and otherwise as given."""
    order: list[int] = []
    placed: set[int] = set()
    for joint in range(len(parents)):
        chain = []
        while joint >= 0 and joint not in placed:
            chain.append(joint)
            placed.add(joint)
            joint = int(parents[joint])
        order.extend(reversed(chain))
    return np.array(order, dtype=np.intp)


def _rest_pose(skeleton: UsdSkel.Skeleton, n_joints: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Rest translations in the file's units and rest rotations, or None where they are not authored or singular."""
    transforms = skeleton.GetRestTransformsAttr().Get()
    if not isinstance(transforms, Vt.Matrix4dArray) or len(transforms) != n_joints:
        return None
    try:
        translations, rotations, _ = UsdSkel.DecomposeTransforms(transforms)
    except Tf.ErrorException:
        return None
    if not np.isfinite(np.array(translations)).all():
        return None
    return np.array(translations, dtype=np.float64), normalize(np.array(rotations, dtype=np.float64))


def _bone_lengths(skeleton: UsdSkel.Skeleton, n_joints: int) -> list[float]:
    """Bone lengths that Blender writes, in the file's units; empty where there are none."""
    primvar = UsdGeom.PrimvarsAPI(skeleton).GetPrimvar("blender:bone_lengths")
    lengths = primvar.Get() if primvar else None
    return list(lengths) if isinstance(lengths, Vt.FloatArray | Vt.DoubleArray) and len(lengths) == n_joints else []


def _bone_ends(skeleton: UsdSkel.Skeleton, n_joints: int) -> np.ndarray | None:
    """Read the ends of the joints' bones, in the file's units; None where they are not authored."""
    attribute = skeleton.GetPrim().GetAttribute(BONE_ENDS)
    value = attribute.Get() if attribute else None
    if value is None:
        return None
    if not isinstance(value, Vt.Vec3dArray) or len(value) != n_joints or not np.isfinite(np.array(value)).all():
        raise ToolError(
            f"{skeleton.GetPath()}: {BONE_ENDS} must be a double3[] of {n_joints} finite vectors, one for each joint; "
            "correct or remove it."
        )
    return np.array(value)
