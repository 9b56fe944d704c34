"""Measure the turns from sample to sample, and count what else in a file makes interpolation doubtful."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim import rotations as quat
from usd_tools.skel.blocks import frame_blocks
from usd_tools.skel.channels import Channel, step_pairs
from usd_tools.skel.clip import SkelClip

WIDE_DEGREES = 120.0
"""A larger turn in one step is doubtful: beyond 180 degrees a file cannot tell which way round it went."""

UNIT_TOLERANCE = 1e-3
"""Distance from 1 of a norm from which on a quaternion counts as not of unit length."""


@dataclass(frozen=True)
class RotationStep:
    """Turn of a joint from one sample to the next.

    Parameters
    ----------
    joint : str
    start, end : float
        Time codes.
    degrees : float
    """

    joint: str
    start: float
    end: float
    degrees: float

    def stretched(self, stretch: float) -> RotationStep:
        """Multiply its time codes by a number."""
        return replace(self, start=self.start * stretch, end=self.end * stretch)

    def in_words(self, names: Mapping[str, str]) -> str:
        """Describe it, with names of joints by their paths."""
        turn = f"{self.degrees:.1f} degrees from time code {self.start:g} to {self.end:g}"
        return f"joint {names[self.joint]} turns {turn}"


def rotation_steps(clip: SkelClip) -> np.ndarray:
    """Measure the turn of every joint from each sample to the next.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    degrees : array-like, shape=[K - 1, N]
        Zero where a sample is blocked and in stepped pairs, which are meant to jump; empty if no rotations are
        sampled.
    """
    channel = clip.channels.get("rotations")
    if channel is None or not channel.is_animated:
        return np.zeros((0, len(clip.joints)))
    degrees = np.empty((len(channel.codes) - 1, channel.values.shape[1]))
    for frames in frame_blocks(*channel.values.shape[:2]):
        values = channel.values[frames].astype(np.float64)
        norm = np.linalg.norm(values, axis=-1, keepdims=True)
        values = np.where(norm > 0.0, values / np.where(norm > 0.0, norm, 1.0), quat.IDENTITY)
        degrees[frames.start : frames.stop - 1] = np.degrees(quat.distance(values[:-1], values[1:]))
    jumps = step_pairs(channel.codes, clip.codes_per_second) | channel.blocked[:-1] | channel.blocked[1:]
    degrees[jumps] = 0.0
    degrees[channel.holds] = 0.0  # not rounding errors
    return degrees


def largest_step(clip: SkelClip, degrees: np.ndarray) -> RotationStep | None:
    """Find the largest turn among `rotation_steps`; None if there are none."""
    if not degrees.size:
        return None
    k, joint = np.unravel_index(np.argmax(degrees), degrees.shape)
    return _step(clip, degrees, int(k), int(joint))


def wide_steps(clip: SkelClip, degrees: np.ndarray) -> list[RotationStep]:
    """Find turns of more than `WIDE_DEGREES` among `rotation_steps`, in order of time."""
    return [_step(clip, degrees, int(k), int(joint)) for k, joint in np.argwhere(degrees > WIDE_DEGREES)]


def _step(clip: SkelClip, degrees: np.ndarray, k: int, joint: int) -> RotationStep:
    codes = clip.channels["rotations"].codes
    return RotationStep(clip.joints[joint], float(codes[k]), float(codes[k + 1]), float(degrees[k, joint]))


def count_sign_flips(channel: Channel) -> int:
    """Count neighbouring quaternions in opposite half-spaces: harmless in USD, not in editors that use components."""
    count = 0
    for frames in frame_blocks(*channel.values.shape[:2]):
        values = channel.values[frames].astype(np.float64)
        count += int((np.einsum("kni,kni->kn", values[:-1], values[1:]) < 0.0).sum())
    return count


def count_not_unit(channel: Channel) -> int:
    """Count quaternions that are not of unit length."""
    norm = np.sqrt(channel.squares[~channel.blocked])
    return int((np.abs(norm - 1.0) > UNIT_TOLERANCE).sum())
