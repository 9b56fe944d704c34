"""The gradient search: a coarse grid, a descent of each joint from there, and SciPy's L-BFGS-B for all joints at once.

The rotation error is a sum over joints, so one evaluation of the grid, or of the descents, serves all joints at once,
and each takes its own best. The location error couples a joint to those below it; the rotation's best is where the last
descent, which sees both, starts.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geomstats_anim.learning.coupled import search_coupled
from geomstats_anim.learning.descent import ROUGHLY, Search, Tally, free_columns
from geomstats_anim.learning.families import Families
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.learning.settings import check_words
from geomstats_anim.names import ALL_FAMILIES, INVARIANCES

_GRID = np.linspace(-1.5, 1.5, 3)
"""Of log alpha and log beta, for a rough search."""

_ROUNDS, _TILTED = 10, (64, 1, 30)
"""Rounds of a joint's descent; tilted matrices that every joint tries, descents from the best, and their rounds."""


def search_gradient(
    objective: Learnable,
    n_joints: int,
    family: str = "diagonal",
    invariance: str = "joint",
    scheme: str = "geodesic",
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
    rough: bool = False,
) -> Found:
    """Minimise an objective over metrics, and over tensions for a spline.

    Parameters
    ----------
    objective : Learnable
    n_joints : int
    family : str
        "diagonal", "spd": any symmetric positive definite matrix, or "coupled": one over all joints.
        Optional, default: "diagonal".
    invariance : str
        "left", "right", "clip" (the better one for all joints) or "joint" (one per joint).
        Optional, default: "joint".
    scheme : str
        "geodesic", or "geodesic-spline", which has tensions.
        Optional, default: "geodesic".
    progress : callable
        Called with the number of evaluations and the best value so far.
    rough : bool
        Take one search with a coarser grid, fewer steps and fewer tilted matrices, for a fit near the best in a small
        part of the time.
        Optional, default: False.

    Returns
    -------
    found : Found
        Never worse than the bi-invariant metric, with the usual tension and without; nor, unless rough, than what is
        found for a family, scheme or choice of sides that this one contains. A coupled metric is never worse than what
        the family "spd" finds with the same scheme and sides, which are its sides.
    """
    check_words(family, invariance, ALL_FAMILIES)
    tally = Tally(progress)
    if family == "coupled":
        contained = Families(objective, n_joints, tally).best(scheme, "spd", invariance)
        return search_coupled(objective, contained, free_columns("spd", scheme), tally, rough)
    if rough:
        return _search_roughly(objective, n_joints, family, invariance, scheme, tally)
    best = Families(objective, n_joints, tally).best(scheme, family, invariance)
    curve = Search.curve(best.point, best.sides)
    progress(tally.evaluations, best.value)
    return Found(curve, best.value, tally.evaluations)


def _search_roughly(
    objective: Learnable, n_joints: int, family: str, invariance: str, scheme: str, tally: Tally
) -> Found:
    sides = INVARIANCES if invariance in ("clip", "joint") else (invariance,)
    search = Search(objective, n_joints, family, scheme, sides, invariance != "joint", tally)
    grids = {side: search.grid(side, _GRID) for side in sides}
    fits = {side: search.refine(best, (side,) * n_joints, _ROUNDS) for side, best in grids.items()}
    for side, point in fits.items():
        search.offer_by_joint(point, (side,) * n_joints)
    # what is best for rotations may be far from what is best for bone ends alone
    starts = [fits, grids] if objective.kind == "loc" else [fits]
    for start in starts:
        if invariance == "clip" or len(starts) > 1:
            for side, point in start.items():
                search.descend(point, (side,) * n_joints, ROUGHLY)
    if family == "spd":
        search.tilt(*_TILTED)
    search.descend(search.best_point, search.best_sides, ROUGHLY)
    return search.found
