"""Characters for a page, as plain values: what moves, and its motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geomstats_anim import Animation
from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import Body, bounds, capsules, skin
from usd_tools.characters.placement import placed, up_axis
from usd_tools.player.encoding import Steps, encoded
from usd_tools.skel.clip import SkelClip

SKIN, BONES = "skin", "bones"

_CHANNELS = ("rotations", "translations", "scales")
_FINEST = {"rotations": 5e-5, "translations": 1e-5, "scales": 5e-5}
"""Steps of quaternions, of lengths by the size of the character, and of scales."""

_BOUNDED = 200
"""Frames, at most, on which the box of a motion is measured."""

_LARGEST = 32_000


@dataclass(frozen=True, eq=False)
class Character:
    """Character whose motions are packed alike.

    Parameters
    ----------
    original : Animation
        Where it is in the world at the times of all motions.
    up : str
        Axis that is up, "y" or "z".
    bodies : mapping of str to Body
        `SKIN`, where the file has one, and `BONES`.
    steps : mapping of str to Steps
        By channel; of scales only where there are any.
    """

    original: Animation
    up: str
    bodies: dict[str, Body]
    steps: dict[str, Steps]

    @classmethod
    def of(cls, clip: SkelClip, original: Animation, motions: Sequence[Animation]) -> Character:
        """Prepare the character of a clip for an original and other motions, all with the same times."""
        original = placed(clip, original)
        bodies = {name: body for name, body in ((SKIN, skin(clip)), (BONES, capsules(original))) if body.parts}
        places = joint_matrices(original.at_frames(slice(0, 1)))[0, :, :, 3]
        size = max(float(np.ptp(places, axis=0).max()), 1e-6)
        steps = {}
        for name in _CHANNELS:
            values = [_flat(getattr(each, name)) for each in (original, *motions) if getattr(each, name) is not None]
            if len(values) == 1 + len(motions):
                steps[name] = Steps.of(values, _FINEST[name] * (size if name == "translations" else 1.0))
        return cls(original, up_axis(clip), bodies, steps)

    def as_dict(self) -> dict[str, Any]:
        """Return what all motions share, as plain values.

        Returns
        -------
        data : dict
            times: seconds; up; joints: their number; parents; world: matrices by frame, shape=[F, 3, 4], one where it
            stands still; channels: base and unit by channel; bodies: see `body_data`; box: lowest and highest corner of
            what the original fills, and standing: of its first frame, metres.
        """
        original = self.original
        world = np.eye(3, 4)[None] if original.world is None else original.world
        world = world[:1] if (world == world[:1]).all() else world
        some = np.unique(np.linspace(0, original.n_frames - 1, _BOUNDED).astype(int))
        return {
            "times": (original.times - original.times[0]).round(5).tolist(),
            "up": self.up,
            "joints": original.n_joints,
            "parents": original.skeleton.parents.tolist(),
            "world": encoded(world, "<f4"),
            "channels": {name: steps.as_dict() for name, steps in self.steps.items()},
            "bodies": {name: body_data(body) for name, body in self.bodies.items()},
            "box": self._box(some).tolist(),
            "standing": self._box(np.zeros(1, dtype=int)).tolist(),
        }

    def motion(self, animation: Animation) -> dict[str, str]:
        """Return a motion as plain values: channels, `Steps.packed`."""
        return {name: steps.packed(_flat(getattr(animation, name))) for name, steps in self.steps.items()}

    def _box(self, frames: np.ndarray) -> np.ndarray:
        """Measure the box of the original's body, or of its joints if nothing is drawn of it, shape=[2, 3]."""
        animation = self.original.at_frames(frames)
        body = next(iter(self.bodies.values()), None)
        if body is not None:
            return bounds(body, animation)
        places = joint_matrices(animation)[..., 3]
        return np.stack([places.min(axis=(0, 1)), places.max(axis=(0, 1))])


def _flat(values: np.ndarray) -> np.ndarray:
    return values.reshape(len(values), -1)


def body_data(body: Body) -> dict[str, Any]:
    """Return a body as plain values, for skinning on the page.

    Returns
    -------
    data : dict
        influences: joints per point; owners, weights, offsets: of every point and influence; faces: points of each
        triangle; weight, offset: what a whole number of weights and offsets is worth; colors: sRGB, 0 to 255, and
        number of points, of each part; none where the file gives a part no colour.
    """
    (joined,) = body.joined().parts
    markers = joined.markers
    offsets = np.where(markers.weights[..., None] == 0.0, 0.0, markers.offsets)
    weight, offset = (max(float(np.abs(values).max()), 1e-9) / _LARGEST for values in (markers.weights, offsets))
    shares = np.round(markers.weights / weight)
    main = np.abs(shares).argmax(axis=1)  # takes what rounding changes of the sum, so that nothing drifts
    shares[np.arange(len(shares)), main] += np.round(markers.weights.sum(axis=1) / weight) - shares.sum(axis=1)
    has_colors = all(part.color is not None for part in body.parts)
    return {
        "influences": markers.joints.shape[1],
        "owners": encoded(markers.joints, "<u2"),
        "weights": encoded(shares, "<i2"),
        "offsets": encoded(np.round(offsets / offset), "<i2"),
        "faces": encoded(joined.faces, "<u4"),
        "weight": weight,
        "offset": offset,
        "colors": [[*part.color, part.markers.n_markers] for part in body.parts if part.color] if has_colors else [],
    }
