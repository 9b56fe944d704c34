r"""Rates of exponentials of moving rotation vectors, and of curves that are bent by them.

With the right Jacobian :math:`J(c) = 1 - B \hat c + C \hat c^2`, :math:`B = (1 - \cos \theta) / \theta^2`,
:math:`C = (\theta - \sin \theta) / \theta^3` and :math:`\theta = |c|`, the body velocity of :math:`\exp(c(t))` is
:math:`J(c) c'` (Sola, "Quaternion kinematics for the error-state Kalman filter", 2017, equation 143).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array

_SMALL = 0.25
"""Squared angle below which quotients cancel, and series, whose remainders are below rounding, are taken instead."""

_TERMS = 8


class Rates(NamedTuple):
    """Body angular velocity and acceleration of a curve on SO(3), shape=[..., 3]."""

    velocity: Array
    acceleration: Array


def exponential_rates(vector: Array, first: Array, second: Array) -> Rates:
    """Return the rates of exp(c(t)).

    Parameters
    ----------
    vector, first, second : array-like, shape=[..., 3]
        c and its first two derivatives.

    Returns
    -------
    rates : Rates
    """
    versine, rest, by_versine, by_rest = _coefficients(vector)
    growth = 2.0 * (vector * first).sum(axis=-1, keepdims=True)  # of the squared angle
    once, changed = quat.cross(vector, first), quat.cross(vector, second)
    twice = quat.cross(vector, once)
    turned = quat.cross(first, once) + quat.cross(vector, changed)
    velocity = first - versine * once + rest * twice
    acceleration = second - versine * changed + rest * turned + growth * (by_rest * twice - by_versine * once)
    return Rates(velocity, acceleration)


def logarithm_rates(vector: Array, rates: Rates) -> tuple[Array, Array]:
    """Return the first two derivatives of c, shape=[..., 3], for the rates of exp(c): undo `exponential_rates`."""
    first = _divide(vector, rates.velocity)
    # the acceleration is linear in c'', with the same Jacobian
    without = exponential_rates(vector, first, np.zeros_like(first)).acceleration
    return first, _divide(vector, rates.acceleration - without)


def bent_rates(rates: Rates, vector: Array, first: Array, second: Array) -> Rates:
    """Return the rates of g(t) exp(c(t)), by the product rule.

    Parameters
    ----------
    rates : Rates
        Of g.
    vector, first, second : array-like, shape=[..., 3]
        c and its first two derivatives.

    Returns
    -------
    rates : Rates
    """
    bend = exponential_rates(vector, first, second)
    back = quat.exp(-vector)
    carried = quat.rotate(back, rates.velocity)
    acceleration = quat.rotate(back, rates.acceleration) - quat.cross(bend.velocity, carried) + bend.acceleration
    return Rates(carried + bend.velocity, acceleration)


def left_jacobian(vector: Array) -> Array:
    """Differentiate exp(c), as a turn from the left, by c (Sola 2017, equation 145).

    Parameters
    ----------
    vector : array-like, shape=[..., 3]

    Returns
    -------
    jacobian : array-like, shape=[..., 3, 3]
        The transpose of the right Jacobian.
    """
    versine, rest, _, _ = (coefficient[..., None] for coefficient in _coefficients(vector))
    hat = quat.cross(np.eye(3), vector[..., None, :])
    return np.eye(3) + versine * hat + rest * (hat @ hat)


def _divide(vector: Array, velocity: Array) -> Array:
    """Solve J(c) x = velocity for x, shape=[..., 3]."""
    versine, rest, _, _ = _coefficients(vector)
    square = (vector**2).sum(axis=-1, keepdims=True)
    # 1 / theta^2 - sin(theta) / (2 theta (1 - cos(theta)))
    weight = _excess(square) / (2.0 * versine)
    once = quat.cross(vector, velocity)
    return velocity + 0.5 * once + weight * quat.cross(vector, once)


def _coefficients(vector: Array) -> tuple[Array, Array, Array, Array]:
    """Return B and C, and their derivatives by the squared angle, shape=[..., 1]."""
    square = (vector**2).sum(axis=-1, keepdims=True)
    is_small = square < _SMALL
    near, far = np.where(is_small, square, 0.0), np.where(is_small, 1.0, square)
    angle = np.sqrt(far)
    versine = np.where(is_small, _series(near, 2), (1.0 - np.cos(angle)) / far)
    rest = np.where(is_small, _series(near, 3), (angle - np.sin(angle)) / (angle * far))
    by_versine = np.where(is_small, _series(near, 2, True), 0.5 * (1.0 - far * rest - 2.0 * versine) / far)
    by_rest = np.where(is_small, _series(near, 3, True), 0.5 * (versine - 3.0 * rest) / far)
    return versine, rest, by_versine, by_rest


def _excess(square: Array) -> Array:
    """Return (2 B - sin(theta) / theta) / theta^2."""
    is_small = square < _SMALL
    near, far = np.where(is_small, square, 0.0), np.where(is_small, 1.0, square)
    angle = np.sqrt(far)
    direct = (2.0 * (1.0 - np.cos(angle)) / far - np.sin(angle) / angle) / far
    # term by term: 2 (-1)^k / (2k + 4)! is taken from (-1)^k / (2k + 3)!
    powers = [(-1.0) ** k * (1.0 / math.factorial(2 * k + 3) - 2.0 / math.factorial(2 * k + 4)) for k in range(_TERMS)]
    return np.where(is_small, np.polynomial.polynomial.polyval(near, powers), direct)


def _series(square: Array, start: int, derived: bool = False) -> Array:
    """Sum (-s)^k / (2k + start)! over k, or its derivative by s."""
    powers = [(-1.0) ** k / math.factorial(2 * k + start) for k in range(_TERMS + 1)]
    if derived:
        powers = [k * power for k, power in enumerate(powers)][1:]
    return np.asarray(np.polynomial.polynomial.polyval(square, powers))
