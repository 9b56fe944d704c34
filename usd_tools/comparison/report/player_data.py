"""Data that the player on the page shows: the character of every clip, and its motion by every scheme and rate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from usd_tools.comparison.report.scenes import Scene, joined
from usd_tools.figures.style import TRUTH, look
from usd_tools.player.characters import Character

BUDGET = 32_000_000
"""Bytes of all motions before they are compressed; beyond it the player shows every second frame, or fewer."""

_JOINT = 14
"""Bytes of a joint in a frame: a quaternion and a place, in whole numbers of 16 bits."""


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
        clip, rate: what it begins with; truth: the original's colour; colors: by word; clips: name, frames (their
        numbers in the clip), character (see `Character.as_dict`), truth (a motion), travels (whether the camera should
        follow), and rates: rate, keys (places in frames), start (place of the frame to begin with), schemes: word,
        motion, errors (centimetres). Motions are those of `Character.motion`.
    """
    sizes = [_JOINT * len(s.times) * s.stretches[0].n_joints * (1 + len(s.rebuilt)) for s in scenes]
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
    truth = first.original.at_frames(frames)
    moves = [
        {word: joined(rebuilt.stretches).at_frames(frames) for word, rebuilt in scene.rebuilt.items()}
        for scene in scenes
    ]
    character = Character.of(first.compared.clip, truth, [motion for by_word in moves for motion in by_word.values()])
    shared = character.as_dict()
    (low, high), (left, right) = np.array(shared["box"]), np.array(shared["standing"])
    level = [0, 2] if character.up == "y" else [0, 1]
    return {
        "name": name,
        "frames": frames.tolist(),
        "character": shared,
        "truth": character.motion(truth),
        "travels": bool(((high - low)[level] > 1.5 * (right - left).max()).any()),
        "rates": [
            {
                "rate": scene.rate,
                "keys": np.flatnonzero(scene.is_key[frames]).tolist(),
                "start": scene.most_different // stride,
                "schemes": [
                    {
                        "word": word,
                        "motion": character.motion(motion),
                        "errors": scene.errors[word][frames].round(3).tolist(),
                    }
                    for word, motion in by_word.items()
                ],
            }
            for scene, by_word in zip(scenes, moves, strict=True)
        ],
    }
