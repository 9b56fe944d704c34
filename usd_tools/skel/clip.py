"""Read a SkelAnimation with its skeleton, and give its samples as `Animation`, in seconds and metres."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pxr import Usd

from geomstats_anim import Animation, Skeleton
from geomstats_anim.names import repeated_name
from geomstats_anim.rotations import IDENTITY, normalize
from usd_tools.console.errors import Messages, ToolError
from usd_tools.skel.blocks import frame_blocks
from usd_tools.skel.channels import JOINT_CHANNELS, Channel, sampled_alike, step_pairs
from usd_tools.skel.clip_channels import check_rotations, check_times, read_channels
from usd_tools.skel.clip_notes import binding_notes, composition_notes, missing_note, variant_notes
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.gaps import Gaps, fill_gaps, has_no_length
from usd_tools.skel.joint_names import names_note, read_names
from usd_tools.skel.packed import PackedMotion, read_packed
from usd_tools.skel.skeleton import BoundSkeleton, metres_per_unit, read_skeleton, world_matrices
from usd_tools.skel.source_codes import stored_source_codes
from usd_tools.skel.unpacked import unpack_motion, unpacked_stage


class Stretch(NamedTuple):
    """Samples between value blocks, steps and cuts, so that a curve may lead through them.

    Attributes
    ----------
    span : slice
        Which samples of their channels.
    keys : Animation
        The same samples, seconds and metres.
    """

    span: slice
    keys: Animation


@dataclass(frozen=True, eq=False)
class SkelClip:
    """A SkelAnimation and the skeleton that it drives.

    Parameters
    ----------
    source : AnimationSource
    skeleton : Skeleton
        All joints of the bound skeleton, then those that only the animation has, parents first; metres.
    rest_scales : array-like, shape=[B, 3]
        Of its joints in their rest pose.
    joints : tuple of str, shape=[N]
        The animation's joints, in its own order.
    columns : array-like of int, shape=[N]
        Where each of them is in `skeleton`.
    channels : mapping of str to Channel
        What is authored.
    missing : mapping of str to array-like, shape=[N, C]
        Values for channels that are not authored, though others are: without them USD shows the rest pose.
    world_scale : float
        Metres per unit of the file.
    codes_per_second : float
    notes : tuple of str
        Sentences about what a user should know.
    given_cuts : array-like, shape=[C, 2]
        Time codes of the samples before and after each cut.
        Optional, default: None, cuts are found where the pose jumps.
    gaps : mapping of str to Gaps
        What was filled in where channels have no value, see `read_clip`.
    """

    source: AnimationSource
    skeleton: Skeleton
    rest_scales: np.ndarray
    joints: tuple[str, ...]
    columns: np.ndarray
    channels: Mapping[str, Channel]
    missing: Mapping[str, np.ndarray]
    world_scale: float
    codes_per_second: float
    notes: tuple[str, ...] = ()
    given_cuts: np.ndarray | None = None
    gaps: Mapping[str, Gaps] = field(default_factory=dict)

    @property
    def path(self) -> str:
        """Path of the SkelAnimation."""
        return self.source.path

    @property
    def is_animated(self) -> bool:
        """Return whether there is anything to interpolate."""
        return any(channel.is_animated for channel in self.channels.values())

    @cached_property
    def codes(self) -> np.ndarray:
        """Time codes of all samples of animated channels, shape=[K], increasing."""
        codes = [channel.codes for channel in self.channels.values() if channel.is_animated]
        return np.unique(np.concatenate(codes)) if codes else np.zeros(0)

    @property
    def steps(self) -> np.ndarray:
        """Return whether each gap between `codes` is a step and not motion, shape=[K - 1]."""
        return step_pairs(self.codes, self.codes_per_second)

    @cached_property
    def cuts(self) -> np.ndarray:
        """Time codes of the samples before and after each cut, shape=[C, 2]; see `find_cuts`."""
        if self.given_cuts is not None:
            return self.given_cuts
        from usd_tools.skel.cuts import find_cuts_in_parts

        joint_channels = {name: self.channels[name] for name in JOINT_CHANNELS if name in self.channels}
        found = [np.zeros((0, 2))]
        for names in sampled_alike({name: each for name, each in joint_channels.items() if each.is_animated}):
            channel = self.channels[names[0]]
            for span in channel.spans:
                codes = channel.codes[span]
                blocks = frame_blocks(len(codes), self.skeleton.n_joints)
                parts = (self.keys(names, slice(span.start + a.start, span.start + a.stop)) for a in blocks)
                before = np.flatnonzero(find_cuts_in_parts(codes / self.codes_per_second, parts))
                found.append(np.stack([codes[before], codes[before + 1]], axis=-1))
        return np.unique(np.concatenate(found), axis=0)

    def samples_per_second(self, codes: np.ndarray | None = None) -> float:
        """Return the usual rate of samples, steps left aside.

        Parameters
        ----------
        codes : array-like, shape=[K]
            Time codes of two samples or more.
            Optional, default: `codes` of the clip.
        """
        codes = self.codes if codes is None else codes
        gaps = np.diff(codes)[~step_pairs(codes, self.codes_per_second)]
        return float(self.codes_per_second / np.median(gaps))

    def stretches(self, names: Sequence[str]) -> Iterator[Stretch]:
        """Part the samples of some channels at value blocks, steps and cuts.

        Parameters
        ----------
        names : sequence of str
            Channels that have the same samples; the others stay at the pose of their first sample.

        Yields
        ------
        stretch : Stretch
            Of two samples at least.

        Raises
        ------
        ToolError
            If a quaternion has no length.
        """
        for span in self.spans(names[0]):
            yield Stretch(span, self.keys(names, span))

    def spans(self, name: str) -> list[slice]:
        """Return which samples of a channel belong to each stretch; see `stretches`."""
        return self.channels[name].stretches(self.codes_per_second, self.cuts)

    def keys(self, names: Sequence[str], samples: slice | np.ndarray) -> Animation:
        """Make an animation of the whole skeleton from samples of some channels, none of them blocked.

        `stretches` says which samples one curve may go through, and what the parameters are.
        """
        codes = self.channels[names[0]].codes[samples]
        pose = {
            "rotations": self.skeleton.rest_rotations,
            "translations": self.skeleton.rest_translations,
            "scales": self.rest_scales,
        }
        arrays: dict[str, np.ndarray] = {}
        for name, rest in pose.items():
            channel = self.channels.get(name)
            if channel is None and name == "scales" and (rest == 1.0).all():
                continue
            arrays[name] = np.tile(rest, (len(codes), 1, 1))
            if channel is not None:
                values = channel.values[samples] if name in names else channel.default[None]
                arrays[name][:, self.columns] = self._to_metric_units(name, values)
        return Animation(self.skeleton, codes / self.codes_per_second, **arrays, world=self._placements(codes))

    def joint_keys(self, names: Sequence[str], samples: slice, joints: slice) -> Animation:
        """Make an animation of some of the animation's joints, apart from their tree, from samples of some channels.

        As every joint is interpolated by itself, curves through it are those through `keys`.
        """
        columns = self.columns[joints]
        skeleton = Skeleton(
            self.joints[joints],
            np.full(len(columns), -1),
            self.skeleton.rest_translations[columns],
            self.skeleton.rest_rotations[columns],
        )
        codes = self.channels[names[0]].codes[samples]
        arrays: dict[str, np.ndarray] = {}
        for name in ("rotations", "translations", "scales"):
            if name in names:
                arrays[name] = self._to_metric_units(name, self.channels[name].values[samples, joints])
            elif name != "scales":
                arrays[name] = np.tile(getattr(skeleton, f"rest_{name}"), (len(codes), 1, 1))
        return Animation(skeleton, codes / self.codes_per_second, **arrays)

    @cached_property
    def _is_rigid(self) -> bool:
        """Return whether lengths in the world are those of `skeleton` at all times."""
        if not self.source.rig:
            return True
        matrices = self.world_matrices(self.codes) / self._file_scale
        if not np.isfinite(matrices).all():  # no place in the world: its own space is taken, which a note says
            return True
        linear = matrices[:, :3, :3]
        return np.allclose(linear @ linear.transpose(0, 2, 1), np.eye(3), rtol=0.0, atol=1e-6)

    def world_matrices(self, codes: np.ndarray) -> np.ndarray:
        """Read the matrices from the skeleton's space to the world, see `skeleton.world_matrices`."""
        return world_matrices(self._placed.GetPrimAtPath(self.source.rig[0].GetPath()), codes)

    @cached_property
    def _placed(self) -> Usd.Stage:
        """A stage on which the skeleton moves as a whole as it should: that of the file, unless this is packed."""
        return unpacked_stage(self.source) if self.source.xforms else self.source.stage

    @property
    def _file_scale(self) -> float:
        """World units of the file per unit of the skeleton's space."""
        return self.world_scale / metres_per_unit(self.source.stage)

    def _placements(self, codes: np.ndarray) -> np.ndarray | None:
        """Return where the skeleton is in the world, see `Animation`; None where that changes no length."""
        return None if self._is_rigid else self.placements(codes)

    def placements(self, codes: np.ndarray) -> np.ndarray | None:
        """Return where the skeleton is in the world, shape=[K, 3, 4], see `Animation`; None if it is nowhere."""
        if not self.source.rig:
            return None
        matrices = self.world_matrices(codes).transpose(0, 2, 1)[:, :3] / self._file_scale
        if not np.isfinite(matrices).all():
            return None
        return np.concatenate([matrices[..., :3], matrices[..., 3:] * self.world_scale], axis=-1)

    def _to_metric_units(self, name: str, values: np.ndarray) -> np.ndarray:
        values = values.astype(np.float64)
        if name == "translations":
            return values * self.world_scale
        if name == "rotations":
            # of joints that never move, see `check_rotations`: OpenUSD shows them unturned
            values[has_no_length(values)] = IDENTITY
            return normalize(values)
        return values

    def to_file_units(self, name: str, animation: Animation) -> np.ndarray:
        """Return the values of a channel in the file's unit and its order of joints, shape=[F, N, C], float64."""
        return self.values_of(name, getattr(animation, name)[:, self.columns])

    def values_of(self, name: str, values: np.ndarray) -> np.ndarray:
        """Return values of a channel in the file's unit, float64."""
        return values / self.world_scale if name == "translations" else values


def read_clips(
    sources: Sequence[AnimationSource], messages: Messages, hides_variants: bool = True, fills_gaps: bool = False
) -> list[SkelClip]:
    """Read animations; one of several that is broken is named, and left as it is.

    Parameters
    ----------
    sources : sequence of AnimationSource
    messages : Messages
        Told of those that are broken.
    hides_variants : bool
        False where what is written goes into the chosen variants: no note says then that it hides the others.
        Optional, default: True.
    fills_gaps : bool
        See `read_clip`.
        Optional, default: False.

    Returns
    -------
    clips : list of SkelClip
        At least one, in the same order.

    Raises
    ------
    ToolError
        If none can be read.
    """
    clips: list[SkelClip] = []
    errors: list[ToolError] = []
    for source in sources:
        try:
            clip = read_clip(source, fills_gaps)
            hidden = () if hides_variants else variant_notes(clip)
            clips.append(replace(clip, notes=tuple(note for note in clip.notes if note not in hidden)))
        except ToolError as error:
            errors.append(error)
    if not clips:
        raise errors[0]
    for broken in errors:
        messages.warn(f"{str(broken).rstrip('.')}; it is left as it is (--prim chooses animations).")
    return clips


def read_clip(source: AnimationSource, fills_gaps: bool = False) -> SkelClip:
    """Read an animation and the skeleton that it drives.

    Parameters
    ----------
    source : AnimationSource
    fills_gaps : bool
        Fill in samples that are not finite and, of joints that move, rotations of no length; `gaps` tells them.
        Optional, default: False, they are refused.

    Returns
    -------
    clip : SkelClip

    Raises
    ------
    ToolError
        If joints repeat, a value has the wrong size, a number is not finite, or a joint that moves has a rotation of no
        length.
    """
    joints = read_names(source.prim, "joints")
    twice = repeated_name(joints)
    if twice is not None:
        raise ToolError(f"{source.path}: joint {twice} is listed twice in joints; repair the file.")
    channels, notes = read_channels(source, joints, fills_gaps)
    gaps: dict[str, Gaps] = {}
    if fills_gaps:
        channels, gaps = fill_gaps(source.path, joints, channels, notes)
    check_rotations(source.path, joints, channels.get("rotations"))
    rate = source.stage.GetTimeCodesPerSecond()
    for channel in channels.values():
        check_times(source.path, channel.codes, rate)
    packed = read_packed(source.prim, channels)
    bound = read_skeleton(source, joints, channels if packed is None else _at_all_frames(channels, packed))
    absent = [name for name in JOINT_CHANNELS if name not in channels and not _is_blocked(source.prim, name)]
    is_partly_authored = joints and any(name in channels for name in JOINT_CHANNELS)
    missing = _rest_values(bound, absent) if is_partly_authored else {}
    clip = SkelClip(
        bound.source,
        bound.skeleton,
        bound.rest_scales,
        joints,
        bound.columns,
        channels,
        missing,
        bound.world_scale,
        rate,
        gaps={} if packed is not None else gaps,  # of the preview, which packed motion replaces
    )
    if packed is not None:
        unpacked = unpack_motion(clip, packed)
        moved = replace(clip.source, xforms=unpacked.xforms)
        clip = replace(clip, source=moved, channels={**channels, **unpacked.channels})
    stored = stored_source_codes(source.prim, clip.codes)
    if stored is not None:
        # The samples that are left say nothing of the gaps between them.
        clip = replace(clip, given_cuts=stored.cuts)
    notes += bound.notes
    if is_partly_authored and absent:
        notes.append(missing_note(clip, absent))
    about_names = names_note(clip.source.rig[0] if clip.source.rig else source.prim)
    notes += [] if about_names is None else [about_names]
    return replace(clip, notes=(*notes, *binding_notes(clip), *composition_notes(clip)))


def _at_all_frames(channels: Mapping[str, Channel], packed: PackedMotion) -> dict[str, Channel]:
    """Return channels of a packed animation as far as a skeleton depends on them: when they are, and their start."""
    return {
        name: replace(channel, codes=packed.codes) if len(channel.codes) else channel
        for name, channel in channels.items()
    }


def _is_blocked(prim: Usd.Prim, name: str) -> bool:
    """Return whether an attribute has no value because its author says so."""
    attribute = prim.GetAttribute(name)
    return bool(attribute) and (attribute.GetNumTimeSamples() > 0 or attribute.GetResolveInfo().ValueIsBlocked())


def _rest_values(bound: BoundSkeleton, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Return values of the rest pose for some channels, as far as it is known, shape=[N, C], in the file's unit."""
    skeleton, columns = bound.skeleton, bound.columns
    rest = {
        "rotations": skeleton.rest_rotations[columns],
        "translations": skeleton.rest_translations[columns] / bound.world_scale,
        "scales": bound.rest_scales[columns],
    }
    return {name: rest[name] for name in names if name == "scales" or bound.has_rest}
