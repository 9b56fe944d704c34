"""Distances of unpacked motion from its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.markers import Markers, distances_between, joint_matrices
from geomstats_anim.rotations import Array
from usd_tools.packing.frames import Frames
from usd_tools.skel.channels import Channel


class Errors(NamedTuple):
    """Errors at all frames, that of the source's animation first.

    Attributes
    ----------
    metres : array-like, shape=[F, B]
        Largest distance of the measured points of each joint from their places in the world.
    degrees : array-like, shape=[F, B]
        Angles between local rotations.
    jitter : float
        Root mean square of the second difference of the error of joints in the world, metres per frame squared.
    scales, weights : float or None
        Largest differences; None if they do not move.
    """

    metres: Array
    degrees: Array
    jitter: float
    scales: float | None
    weights: float | None

    @classmethod
    def of(
        cls, frames: Frames, channels: Mapping[str, Channel], markers: Markers, placements: Array | None = None
    ) -> Errors:
        """Compare unpacked channels with those of the source.

        Parameters
        ----------
        frames : Frames
        channels : mapping of str to Channel
        markers : Markers
        placements : array-like, shape=[F, 3, 4]
            Where unpacked transforms place the skeleton at all frames.
            Optional, default: where the source has it.
        """
        truth, ours = frames.animation, frames.animation_of({name: channels[name] for name in frames.moving})
        if placements is not None:
            truth, ours = replace(truth, world=frames.placements), replace(ours, world=placements)
        placed = joint_matrices(ours), joint_matrices(truth)
        scales = weights = None
        if "scales" in frames.moving and truth.scales is not None and ours.scales is not None:
            scales = float(np.abs(ours.scales - truth.scales).max(initial=0.0))
        before, after = frames.weights_of(frames.moving), frames.weights_of(channels)
        if before is not None and after is not None:
            weights = float(np.abs(after - before).max(initial=0.0))
        return cls(
            distances_between(*placed, markers),
            np.degrees(quat.distance(truth.rotations, ours.rotations)),
            _jitter(placed[0][..., 3] - placed[1][..., 3]),
            scales,
            weights,
        )

    @property
    def largest(self) -> float:
        """Largest distance, metres."""
        return float(self.metres.max(initial=0.0))

    def as_dict(self) -> dict[str, Any]:
        """Return plain values, centimetres and degrees."""
        return {
            "centimetres": _statistics(100.0 * self.metres),
            "degrees": _statistics(self.degrees),
            "jitter_centimetres": 100.0 * self.jitter,
            "scales": self.scales,
            "weights": self.weights,
        }


def _jitter(off: Array) -> float:
    """Return the root mean square of the second difference of vectors, shape=[F, B, 3]."""
    if off.shape[0] < 3 or not off.shape[1]:
        return 0.0
    return float(np.sqrt((np.diff(off, 2, axis=0) ** 2).sum(axis=-1).mean()))


def _statistics(values: Array) -> dict[str, float]:
    if not values.size:
        return {"mean": 0.0, "percentile_99": 0.0, "largest": 0.0}
    return {
        "mean": float(values.mean()),
        "percentile_99": float(np.percentile(values, 99.0)),
        "largest": float(values.max()),
    }
