"""Transforms that move a character as a whole, packed with its joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomstats_anim.codec import ExtraChannel
from geomstats_anim.markers import Markers, joint_matrices
from geomstats_anim.rotations import Array
from usd_tools.console.errors import Messages
from usd_tools.packing.frames import Frames
from usd_tools.skel.channels import JOINT_CHANNELS, Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.packed_xforms import column_names, from_parts, to_parts
from usd_tools.skel.xforms import XformOp, find_xform_ops

_SAMPLED = 24
"""Frames at which it is measured how far numbers of transforms move points."""

_NUDGE = 1e-2
"""Of the largest of some numbers: by how much they are moved for that."""

_SMALLEST_NUDGE = 1e-3

_LEAST_REACH = 1e-6
"""Metres per unit, for numbers that move nothing."""

_SHARES = (1.0 / 64.0, 0.5)
"""Least and largest share of the tolerance for transforms."""


def ops_to_pack(clip: SkelClip, messages: Messages) -> list[XformOp]:
    """Find the transform ops that can be packed with a clip; say of the others that they keep their samples."""
    found = find_xform_ops(clip.source)
    for note in found.notes:
        messages.warn(note)
    chosen: list[XformOp] = []
    for op in found.ops:
        reason = _reason_to_keep(op, clip)
        if reason:
            messages.warn(f"{op.attribute.GetPath()} keeps its {len(op.channel.codes)} samples: {reason}.")
        else:
            chosen.append(op)
    return chosen


def _reason_to_keep(op: XformOp, clip: SkelClip) -> str:
    source, codes = clip.source, op.channel.codes
    if not clip.skeleton.n_joints:
        return "there is no joint to measure errors on"
    if len(source.prims) > 1 or source.prim.IsInstanceProxy():
        return f"{clip.path} is shared by instances"
    if not source.rig[0].GetPath().HasPrefix(op.attribute.GetPrimPath()):
        return f"errors are measured on {source.rig[0].GetPath()}, which it does not move"
    if codes[0] < clip.codes[0] or codes[-1] > clip.codes[-1]:
        return f"it moves before or after {clip.path} does"
    if clip.placements(clip.codes) is None:
        return "it has values that are not finite"
    if not np.linalg.det(clip.world_matrices(clip.codes[:1])[0, :3, :3]):
        return "the character has no size where it begins"
    return ""


@dataclass(frozen=True, eq=False)
class Transforms:
    """Ops at all frames of a clip.

    Parameters
    ----------
    frames : Frames
    ops : sequence of XformOp
        Those of its `xforms`.
    """

    frames: Frames
    ops: Sequence[XformOp]

    @cached_property
    def columns(self) -> dict[str, Array]:
        """Numbers that are packed, at all frames, by the names of channels, shape=[F, C]."""
        prim, found = self.frames.clip.source.prim, {}
        for op in self.ops:
            numbers = self.frames.filled(self.frames.xforms[_path(op)])[:, 0]
            found.update(column_names(prim, op.attribute, to_parts(op.attribute, numbers)))
        return found

    def samples(self, columns: Mapping[str, Array]) -> dict[str, Channel]:
        """Return the ops at all frames if other numbers were those of `columns`, by path."""
        prim, found = self.frames.clip.source.prim, {}
        for op in self.ops:
            channel = self.frames.xforms[_path(op)]
            numbers = self.frames.filled(channel)[:, 0]
            own = to_parts(op.attribute, numbers)
            changed = {
                part: columns[name] for part, name in zip(own, column_names(prim, op.attribute, own), strict=True)
            }
            values = from_parts(op.attribute, changed, numbers[0])[:, None]
            at = np.isin(self.frames.codes, channel.codes)
            found[_path(op)] = replace(channel, values=np.where(channel.blocked[:, None, None], 0.0, values[at]))
        return found

    def placements(self, columns: Mapping[str, Array]) -> Array:
        """Return where the skeleton is at all frames if other numbers were those of `columns`, shape=[F, 3, 4]."""
        return self._placed(columns, self.frames.codes)

    def _placed(self, columns: Mapping[str, Array], codes: np.ndarray) -> Array:
        clip = self.frames.clip
        xforms = {**clip.source.xforms, **self.samples(columns)}
        placements = replace(clip, source=replace(clip.source, xforms=xforms)).placements(codes)
        return np.full((len(codes), 3, 4), np.inf) if placements is None else placements

    @cached_property
    def share(self) -> float:
        """Part of the tolerance that the transforms may take: what their numbers are among all."""
        n_own = sum(values.shape[1] for values in self.columns.values())
        n_joints = 3 * len(self.frames.clip.joints) * sum(name in JOINT_CHANNELS for name in self.frames.moving)
        return float(np.clip(n_own / max(n_own + n_joints, 1), *_SHARES)) if n_own else 0.0

    def channels(self, metres: float, markers: Markers) -> dict[str, ExtraChannel]:
        """Return what is packed, so that markers move by some metres at most, if errors add up as independent ones."""
        if not self.columns:
            return {}
        n_own = sum(values.shape[1] for values in self.columns.values())
        reach = self._reach(markers)
        return {
            name: ExtraChannel(values, metres / (np.sqrt(n_own) * max(reach[name], _LEAST_REACH)))
            for name, values in self.columns.items()
        }

    def _reach(self, markers: Markers) -> dict[str, float]:
        """Return how many metres a unit of each channel moves markers at most."""
        frames = self.frames
        chosen = np.unique(np.linspace(0, len(frames.codes) - 1, _SAMPLED).astype(np.intp))
        codes, corners = frames.codes[chosen], self._corners(chosen, markers)
        before, found = self._placed(self.columns, codes), {}
        for name, values in self.columns.items():
            nudge, largest = max(_NUDGE * float(np.abs(values).max(initial=0.0)), _SMALLEST_NUDGE), 0.0
            for column in np.eye(values.shape[1]):
                moved = self._placed({**self.columns, name: values + nudge * column}, codes) - before
                off = np.einsum("fij,fpj->fpi", moved[:, :, :3], corners) + moved[:, None, :, 3]
                largest = max(largest, float(np.linalg.norm(off, axis=-1).max(initial=0.0)) / nudge)
            found[name] = largest
        return found

    def _corners(self, chosen: np.ndarray, markers: Markers) -> Array:
        """Return the corners of the box around all markers, in the space of the skeleton, shape=[F, 8, 3], metres."""
        places = markers.places(joint_matrices(replace(self.frames.animation.at_frames(chosen), world=None)))
        box = np.stack([places.min(axis=1), places.max(axis=1)])
        which = np.array(np.meshgrid(*[[0, 1]] * 3)).reshape(3, -1).T
        return np.stack([box[bits, :, range(3)].T for bits in which], axis=1)


def _path(op: XformOp) -> str:
    return str(op.attribute.GetPath())
