"""Motion for the player on the page: points of every clip and scheme, small enough to be written into it."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from usd_tools.comparison.report.scenes import Scene
from usd_tools.figures.style import TRUTH, look

BUDGET = 32_000_000
"""Bytes of all points before they are compressed; beyond it the player shows every second frame, or fewer."""

_LARGEST = 32_000
"""Of the whole numbers that stand for coordinates."""


def player_data(scenes: Sequence[Scene], chosen: Scene) -> dict[str, Any]:
    """Return what the player shows, as plain values.

    Parameters
    ----------
    scenes : sequence of Scene
    chosen : Scene
        What it begins with.

    Returns
    -------
    data : dict
        clip, rate: what it begins with; colors: by word; clips: name, frames (their numbers in the clip), times
        (seconds), lines (pairs of points), unit (metres), truth, travels (whether the camera should follow), and rates:
        rate, keys (places in frames), start (place of the frame to begin with), schemes: word, points, errors
        (centimetres). Points are `packed`.
    """
    sizes = [2 * scene.points().size * (1 + len(scene.rebuilt)) for scene in scenes]
    stride = max(1, -(-sum(sizes) // BUDGET))
    by_clip: dict[str, list[Scene]] = {}
    for scene in scenes:
        by_clip.setdefault(scene.name, []).append(scene)
    words = dict.fromkeys(word for scene in scenes for word in scene.rebuilt)
    return {
        "clip": chosen.name,
        "rate": chosen.rate,
        "truth": TRUTH,
        "colors": {word: look(word).color for word in words},
        "clips": [_clip(name, rates, stride) for name, rates in by_clip.items()],
    }


def _clip(name: str, scenes: Sequence[Scene], stride: int) -> dict[str, Any]:
    first = scenes[0]
    frames = np.arange(0, len(first.times), stride)
    truth = first.points()[frames]
    moves = [{word: scene.points(word)[frames] for word in scene.rebuilt} for scene in scenes]
    middle = 0.5 * (truth.max(axis=(0, 1)) + truth.min(axis=(0, 1)))
    every = [truth, *(points for by_word in moves for points in by_word.values())]
    unit = max(float(max(np.abs(points - middle).max() for points in every)), 1e-6) / _LARGEST
    times = first.times[frames] - first.times[0]
    return {
        "name": name,
        "frames": frames.tolist(),
        "times": times.round(5).tolist(),
        "lines": first.bones.lines.tolist(),
        "points": truth.shape[1],
        "unit": float(f"{unit:.6g}"),
        "truth": packed((truth - middle) / unit),
        "travels": bool(np.ptp(truth.mean(axis=1)[:, :2], axis=0).max() > np.ptp(truth[0], axis=0).max()),
        "rates": [
            {
                "rate": scene.rate,
                "keys": np.flatnonzero(scene.is_key[frames]).tolist(),
                "start": scene.most_different // stride,
                "schemes": [
                    {
                        "word": word,
                        "points": packed((points - middle) / unit),
                        "errors": scene.errors[word][frames].round(3).tolist(),
                    }
                    for word, points in by_word.items()
                ],
            }
            for scene, by_word in zip(scenes, moves, strict=True)
        ],
    }


def packed(points: np.ndarray) -> str:
    """Pack points, shape=[F, P, 3]: whole numbers of 16 bits, as differences in time, deflated, in base 64.

    Each coordinate of each point is a row of F differences, which wrap around.
    """
    whole = np.round(points).astype("<i2").reshape(len(points), -1)
    steps = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype="<i2"))
    return base64.b64encode(zlib.compress(np.ascontiguousarray(steps.T).tobytes(), 9)).decode("ascii")
