"""The interface between a search for a metric and its objective, and its result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from geomstats_anim.animation import Skeleton
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array


class Learnable(Protocol):
    """The interface of an objective."""

    kind: str

    @property
    def skeleton(self) -> Skeleton:
        """Return the skeleton, whose joints have parameters."""
        ...

    def value(self, curve: CurveParameters) -> float:
        """Return the quality; 0 is perfect."""
        ...

    def quality(self, curve: CurveParameters) -> float:
        """Return the same without smoothing."""
        ...

    def errors_by_joint(self, curve: CurveParameters) -> Array:
        """Return the rotation error of each joint, and its part of the quality, shape=[2, B]."""
        ...

    def value_and_gradient(self, curve: CurveParameters) -> tuple[float, Array]:
        """Return the quality, and its derivative, shape=[B, 7]; see `Objective.value_and_gradient`."""
        ...

    def rotation_errors_by_joint(self, curve: CurveParameters, joints: np.ndarray | None = None) -> Array:
        """Return the weighted rotation error of each joint, shape=[B], which depends on its own parameters only.

        With the indices of some joints, shape=[J], the curve and the errors are theirs alone.
        """
        ...

    def rotation_errors_and_gradient(self, curve: CurveParameters, joints: np.ndarray) -> tuple[Array, Array]:
        """Return the same of some joints, shape=[J], and its derivative, shape=[J, 7]; the curve is theirs alone."""
        ...


@dataclass(frozen=True)
class Found:
    """Parameters of a curve, and their value."""

    curve: CurveParameters
    value: float
    evaluations: int
