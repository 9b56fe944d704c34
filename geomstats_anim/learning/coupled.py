"""The search for metrics that couple joints: one descent over all numbers of the metric, from a small coupling.

It starts from the bi-invariant metric, where the objective is smooth: at the optimum of the smaller family, geodesics
are about to cease to be the shortest. That optimum is what is returned where the descent finds nothing better.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from geomstats_anim.learning.descent import BOUNDS, TENSIONS, Search, Tally, by_coordinates
from geomstats_anim.learning.families import Optimum
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

RANK = 3
"""Of the coupling: how many sets of velocities come together."""

_START = 0.05
"""Standard deviation of the coupling at the start, which has no derivative at 0."""

_LARGEST = 2.0
"""Largest number of a coupling."""

_STEPS, _ROUGH_STEPS = 80, 25
_ENOUGH = 1e-4
"""Relative change of the value at which the descent ends."""


def search_coupled(
    objective: Learnable, contained: Optimum, columns: list[int], tally: Tally, rough: bool = False
) -> Found:
    """Minimise an objective over metrics that couple joints.

    Parameters
    ----------
    objective : Learnable
    contained : Optimum
        Of the family "spd", with the same scheme and sides.
    columns : list of int
        Of a point, see `Search`, that are free.
    tally : Tally
    rough : bool
        Take fewer steps.
        Optional, default: False.

    Returns
    -------
    found : Found
        Never worse than what is contained.
    """
    from scipy.optimize import minimize

    n_joints = len(contained.point)
    start = np.zeros_like(contained.point)
    start[:, TENSIONS] = contained.point[:, TENSIONS]
    coupling = np.random.default_rng(0).normal(0.0, _START, (n_joints, 3, RANK))
    scale = contained.scale[:, columns]
    coupling_scale, split, unit = float(np.median(scale)), scale.size, max(contained.value, 1e-12)

    def curve_at(flat: Array) -> tuple[Array, CurveParameters]:
        point = start.copy()
        point[:, columns] = flat[:split].reshape(scale.shape) / scale
        plain = Search.curve(point, contained.sides)
        return point, CurveParameters(
            plain.metric,
            plain.tension,
            plain.translation_tension,
            flat[split:].reshape(coupling.shape) / coupling_scale,
        )

    def evaluate(flat: Array) -> tuple[float, Array]:
        point, curve = curve_at(flat)
        value, gradient = objective.value_and_gradient(curve)
        tally.count(value)
        by_point = by_coordinates(np.concatenate([gradient[:, :5], gradient[:, -2:]], axis=1), point)[:, columns]
        parts = (by_point / scale).ravel(), gradient[:, 5:-2].ravel() / coupling_scale
        return value / unit, np.concatenate(parts) / unit

    low, high = np.transpose([BOUNDS[column] for column in columns])
    bound = np.full(coupling.size, _LARGEST * coupling_scale)
    options: Any = {
        "maxcor": 20,
        "maxls": 6,
        "gtol": 1e-9,
        "ftol": _ENOUGH,
        "maxiter": _ROUGH_STEPS if rough else _STEPS,
    }
    result = minimize(
        evaluate,
        np.concatenate([(start[:, columns] * scale).ravel(), coupling.ravel() * coupling_scale]),
        jac=True,
        method="L-BFGS-B",
        bounds=np.stack(
            [np.concatenate([(low * scale).ravel(), -bound]), np.concatenate([(high * scale).ravel(), bound])], axis=-1
        ),
        options=options,
    )
    curve = curve_at(result.x)[1]
    if objective.quality(curve) < contained.quality:
        return Found(curve, objective.value(curve), tally.evaluations)
    same = Search.curve(contained.point, contained.sides)
    return Found(same, contained.value, tally.evaluations)
