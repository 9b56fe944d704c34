"""The error of logarithms that were not found."""

from __future__ import annotations

import numpy as np

from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.kernels.shooting import CONVERGED
from geomstats_anim.riemannian import matrices as mat

_NAMED_FAILURES = 5
"""Most elements that the error names."""


def raise_failures(status: np.ndarray, shape: tuple[int, ...]) -> None:
    """Raise if elements of a batch of a shape have no geodesic, naming them and the remedy."""
    if (status == CONVERGED).all():
        return
    failures = np.argwhere(status.reshape(shape) != CONVERGED)
    names = ", ".join(mat.at("", index) for index in failures[:_NAMED_FAILURES]) if shape else "the pair"
    more = f" and {len(failures) - _NAMED_FAILURES} more" if len(failures) > _NAMED_FAILURES else ""
    sentences = " ".join(str(LogStatus(code)) for code in np.unique(status) if code != CONVERGED)
    raise RuntimeError(f"The logarithm failed for {names}{more}. {sentences} log_solver.solve returns every status.")
