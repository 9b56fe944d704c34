"""Measure how planted points skate and float in a motion that was rebuilt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.contacts.detection import Contacts
from geomstats_anim.markers import joint_places


class Skating(NamedTuple):
    """Errors of planted points.

    Attributes
    ----------
    skate : float
        Centimetres per second that they move along the ground.
    floating : float
        Centimetres that they are above or below their height in the original, on average.
    """

    skate: float
    floating: float


def skating(
    rebuilt: Sequence[Animation], originals: Sequence[Animation], contacts: Sequence[Contacts]
) -> Skating | None:
    """Measure planted points in one or several stretches of a motion.

    Parameters
    ----------
    rebuilt, originals : sequence of Animation
        Same joints and times; the originals are placed in the world, and say where the others are.
    contacts : sequence of Contacts
        Of the originals, so that methods are judged by the same points at the same times.

    Returns
    -------
    skating : Skating or None
        None if no point is planted.
    """
    seconds, way, height = 0.0, 0.0, 0.0
    for motion, original, found in zip(rebuilt, originals, contacts, strict=True):
        places, truth = (_places(each, original, found) for each in (motion, original))
        steps = np.diff(places, axis=0)
        steps -= (steps @ found.up)[..., None] * found.up
        rises = np.abs((places - truth) @ found.up)
        durations = np.diff(found.times)[:, None] * found.planted
        seconds += float(durations.sum())
        way += float(np.linalg.norm(steps, axis=-1)[found.planted].sum())
        height += float((0.5 * (rises[1:] + rises[:-1]) * durations).sum())
    return Skating(100.0 * way / seconds, 100.0 * height / seconds) if seconds > 0.0 else None


def _places(motion: Animation, original: Animation, contacts: Contacts) -> np.ndarray:
    return joint_places(replace(motion, world=original.world), contacts.joints)
