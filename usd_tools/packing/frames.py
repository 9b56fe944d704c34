"""A clip as frames that can be packed: all moving attributes at the same times; where it is cut; what viewers see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomstats_anim import Animation, optimal_keyframes, uniform_keyframes
from geomstats_anim.rotations import Array
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import JOINT_CHANNELS, Channel, held, step_pairs
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.packed import WEIGHTS
from usd_tools.skel.resampling import resample, without_cuts
from usd_tools.skel.xforms import XformOp, cuts_of, resample_op


@dataclass(frozen=True, eq=False)
class Frames:
    """A clip whose moving attributes have samples at all time codes, as USD shows them.

    Parameters
    ----------
    clip : SkelClip
        What does not move is a default.
    codes : array-like, shape=[F]
        Time codes of the frames: of all samples of the source.
    moving : mapping of str to Channel
        Attributes that are packed; samples within value blocks are left out.
    xforms : mapping of str to Channel
        Transform ops that are packed, likewise, by the paths of their attributes.
    jumps : array-like
        Time codes after cuts.
    """

    clip: SkelClip
    codes: np.ndarray
    moving: Mapping[str, Channel]
    xforms: Mapping[str, Channel]
    jumps: np.ndarray

    @classmethod
    def of(cls, clip: SkelClip, ops: Sequence[XformOp] = ()) -> Frames:
        """Sample a clip that is animated, and transforms that move within its time, when any of them has a sample."""
        sampled = [channel.codes for channel in clip.channels.values()] + [op.channel.codes for op in ops]
        codes = np.unique(np.concatenate(sampled))
        names = [name for name, channel in clip.channels.items() if not channel.is_constant]
        if not names:  # one attribute tells how long nothing moves
            names = [next(name for name, channel in clip.channels.items() if channel.is_animated)]
        shown = resample(without_cuts(clip), codes, "slerp").channels
        moving = {name: shown.get(name) or held(clip.channels[name], codes) for name in names}
        told = np.concatenate([channel.codes for channel in moving.values()])
        codes = codes[(codes >= told.min()) & (codes <= told.max())]
        still = {
            name: channel.at(np.zeros(len(channel.codes), dtype=bool))
            for name, channel in clip.channels.items()
            if name not in moving
        }
        cuts = [cuts_of(op, clip, True)[:, 1] for op in ops]
        return cls(
            replace(clip, channels={**still, **moving}, given_cuts=clip.cuts),
            codes,
            moving,
            {str(op.attribute.GetPath()): _as_shown(op, codes, clip.codes_per_second) for op in ops},
            np.unique(np.concatenate([clip.cuts[:, 1], *cuts])),
        )

    @property
    def animation(self) -> Animation:
        """Motion of the joints at all frames, held within value blocks; seconds."""
        return self.animation_of(self.moving)

    def animation_of(self, moving: Mapping[str, Channel]) -> Animation:
        """Return the motion if other samples were those of the moving attributes."""
        full = {
            name: replace(channel, codes=self.codes, values=self.filled(channel)) for name, channel in moving.items()
        }
        clip = replace(self.clip, channels={**self.clip.channels, **full})
        return clip.keys(tuple(full), slice(None))

    def weights_of(self, moving: Mapping[str, Channel]) -> Array | None:
        """Return weights of blend shapes at all frames, shape=[F, N]; None if they do not move."""
        return self.filled(moving[WEIGHTS])[..., 0].astype(np.float64) if WEIGHTS in moving else None

    @cached_property
    def placements(self) -> Array | None:
        """Placement of the skeleton at all frames, shape=[F, 3, 4]; asked for before an open stage is changed."""
        return self.clip.placements(self.codes)

    @property
    def cuts(self) -> list[int]:
        """Frames at which another piece begins: after cuts, steps, and the edges of value blocks."""
        starts = [1 + np.flatnonzero(step_pairs(self.codes, self.clip.codes_per_second))]
        starts.append(np.searchsorted(self.codes, self.jumps))
        packed = (*self.moving.values(), *self.xforms.values())
        starts += [1 + np.flatnonzero(np.diff(np.isin(self.codes, _live(each)))) for each in packed]
        return np.unique(np.concatenate(starts)).tolist()

    def preview(self, n_keys: int) -> dict[str, Channel]:
        """Return the moving attributes and transforms with few of their samples, for viewers.

        Parameters
        ----------
        n_keys : int
            0 for the pose in which each attribute begins, at the first and the last frame. Value blocks stay.

        Raises
        ------
        ToolError
            If more samples must stay.
        """
        keys = self.codes[self._keys(n_keys)] if n_keys else self.codes[[0, -1]]
        found = {}
        for name, channel in {**self.moving, **self.xforms}.items():
            edge = channel.blocked.copy()
            edge[:-1] |= channel.blocked[1:]
            edge[1:] |= channel.blocked[:-1]
            few = channel.at(edge | np.isin(channel.codes, keys))
            if not n_keys:
                few = replace(few, values=np.where(few.blocked[:, None, None], few.values, channel.default))
            found[name] = few
        return found

    def _keys(self, n_keys: int) -> np.ndarray:
        """Choose frames from which slerp, which viewers show, rebuilds the motion best."""
        joints_move = any(name in JOINT_CHANNELS for name in self.moving)
        if n_keys >= len(self.codes):
            return np.arange(len(self.codes))
        if not joints_move:
            return uniform_keyframes(len(self.codes), n_keys / len(self.codes))
        try:
            return optimal_keyframes(self.animation, n_keys)
        except ValueError as error:
            raise ToolError(f"{self.clip.path} cannot have a preview of {n_keys} samples: {error}") from error

    def filled(self, channel: Channel) -> np.ndarray:
        """Return values at all frames, shape=[F, N, C]: within value blocks those before, or the first."""
        live = np.flatnonzero(~channel.blocked)
        last = np.maximum(np.searchsorted(channel.codes[live], self.codes, side="right") - 1, 0)
        return channel.values[live[last]]


def _live(channel: Channel) -> np.ndarray:
    return channel.codes[~channel.blocked]


def _as_shown(op: XformOp, codes: np.ndarray, rate: float) -> Channel:
    """Return an op at time codes, its own samples among them, as USD shows it."""
    if np.array_equal(op.channel.codes, codes):
        return op.channel
    return held(resample_op(op, codes, rate, "linear", np.zeros((0, 2))), codes)
