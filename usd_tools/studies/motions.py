"""Motions for the page: a body, and matrices of its joints for each motion, packed."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from geomstats_anim import Animation
from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import body_of
from usd_tools.characters.placement import placed, up_axis
from usd_tools.comparison.report.player_data import packed
from usd_tools.skel.clip import SkelClip

_LARGEST = 32_000
"""Of the whole numbers that stand for coordinates."""


def motion_data(name: str, clip: SkelClip, motions: Mapping[str, Animation]) -> dict[str, Any]:
    """Return what the page draws of a clip, as plain values.

    Parameters
    ----------
    name : str
    clip : SkelClip
    motions : mapping of str to Animation
        The original first; all with the same times.

    Returns
    -------
    data : dict
        name; up: its axis; times: seconds; joints: their number; influences: per point; owners, weights, offsets and
        faces of the body, `encoded`; unit, slope: metres and numbers per whole number; heights: lowest
        and highest place of the original's joints; size: of what has to be seen, metres; motions: matrices by word,
        `packed` by columns.
    """
    original = next(iter(motions.values()))
    (part, *_) = body_of(clip, original).joined().parts
    markers = part.markers
    matrices = {word: joint_matrices(placed(clip, animation)) for word, animation in motions.items()}
    every = np.stack(list(matrices.values()))
    unit = max(float(np.abs(every[..., 3]).max()), 1e-6) / _LARGEST
    slope = max(float(np.abs(every[..., :3]).max()), 1e-6) / _LARGEST
    places = next(iter(matrices.values()))[..., 3]
    up = up_axis(clip)
    heights = places[..., "xyz".index(up)]
    return {
        "name": name,
        "up": up,
        "times": (original.times - original.times[0]).round(5).tolist(),
        "joints": original.n_joints,
        "influences": markers.joints.shape[1],
        "owners": encoded(markers.joints, "<u2"),
        "weights": encoded(markers.weights, "<f4"),
        "offsets": encoded(markers.offsets, "<f4"),
        "faces": encoded(part.faces, "<u4"),
        "unit": unit,
        "slope": slope,
        "heights": [float(heights.min()), float(heights.max())],
        "size": max(float(np.ptp(heights)), float(np.ptp(places, axis=1).max()), 1e-6),
        "motions": {word: packed(_columns(each, unit, slope)) for word, each in matrices.items()},
    }


def _columns(matrices: np.ndarray, unit: float, slope: float) -> np.ndarray:
    """Return the columns of matrices, shape=[F, B, 3, 4], as whole numbers, shape=[F, 4 B, 3]."""
    scaled = matrices / np.array([slope, slope, slope, unit])
    return scaled.transpose(0, 1, 3, 2).reshape(len(matrices), -1, 3)


def encoded(values: np.ndarray, kind: str) -> str:
    """Encode numbers of a type such as "<f4": deflated, in base 64."""
    return base64.b64encode(zlib.compress(np.ascontiguousarray(values, dtype=kind).tobytes(), 9)).decode("ascii")
