"""The rotations of the last few curves, by joint, so that only joints whose parameters are new are rebuilt."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

_CURVES = 4
"""A search mixes its best curve, which may be a mixture itself, with a rival."""


class _Entry(NamedTuple):
    rows: Array
    rotations: Array


class RotationMemory:
    """Rotations that a curve makes, remembered."""

    def __init__(self) -> None:
        self._known: list[_Entry] = []

    def recall(self, curve: CurveParameters, rebuild: Callable[[CurveParameters, np.ndarray], Array]) -> Array:
        """Return the rotations of a curve, shape=[F, B, 4].

        Parameters
        ----------
        curve : CurveParameters
        rebuild : callable
            Takes a curve of some joints, and their indices, shape=[J]; returns their rotations, shape=[F, J, 4].
        """
        rows = _rows(curve)
        missing = np.ones(len(rows), dtype=bool)
        pieces: list[tuple[np.ndarray, Array]] = []
        used: list[_Entry] = []
        unused: list[_Entry] = []
        for entry in self._known:
            same = missing & (rows == entry.rows).all(axis=1)
            missing &= ~same
            pieces.append((same, entry.rotations[:, same]))
            (used if same.any() else unused).append(entry)
        new = np.flatnonzero(missing)
        made = rebuild(curve.at(new), new)
        whole = np.empty((len(made), len(rows), 4))
        for joints, rotations in (*pieces, (new, made)):
            whole[:, joints] = rotations
        # a mixture of what is known need not be kept
        latest = [_Entry(rows, whole)] if len(new) else []
        self._known = [*latest, *used, *unused][:_CURVES]
        return whole


def _rows(curve: CurveParameters) -> Array:
    """Return all numbers that a joint's rotations depend on, shape=[B, 8]."""
    metric = curve.metric
    axes = np.zeros((metric.n_joints, 3)) if metric.axes is None else metric.axes
    return np.column_stack([metric.moments, axes, metric.is_right, curve.tension])
