r"""Cut points: how far along a geodesic from the identity it stays the shortest.

Half turns P_i about the principal axes, and reversal of time, carry geodesics g to geodesics of the same length. Where
an image has another momentum and the same end, the geodesic is shortest no longer (a Maxwell point). With the rotation
:math:`g(t) = (x, w)` as a quaternion that begins at the identity, and the body momentum :math:`M(t) = g^T m`:

* Reversal ends at :math:`g^{-1}`, with the momentum :math:`-M(t)`: the same rotation where w = 0.
* Reversal and P_i end at :math:`P_i g^{-1} P_i`, with the momentum :math:`-P_i M(t)`: the same where :math:`x_i = 0`.
  If :math:`M_i(t / 2) = 0` too, the geodesic is its own image, and nothing happens.

So a shortest geodesic keeps :math:`w > 0` and :math:`x_i(t) M_i(t / 2) > 0` all the way. That this is enough, that is,
that no conjugate point comes before these, is proved where two moments are equal (Podobryaev & Sachkov, "Cut locus of a
left invariant Riemannian metric on SO3 in the axisymmetric case", 2016), and held for three unequal moments in
every comparison with searches in all directions, up to condition 1000; the tests repeat some of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.kernels.rigid_body import playback
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.rotations import Array

_SAMPLES = 24
"""Places along a geodesic that are looked at."""

_PART = 1024
"""Geodesics looked at together; bounds the memory."""

_ROUNDING = 1e-11
"""Error of x and of M / |m|."""

_NUDGE = 1e-5
"""Share of the momentum by which a geodesic is moved out of a plane of symmetry, in which it is its own image."""

_IMAGES = np.concatenate([2.0 * np.eye(3) - 1.0, np.ones((1, 3))])
"""P_i on vectors, and the identity."""


class CutPoints(NamedTuple):
    """Places where geodesics cease to be the shortest.

    Attributes
    ----------
    is_shortest : array-like of bool, shape=[n]
        Whether a geodesic is the shortest to its end.
    image : array-like, shape=[n, 3]
        Otherwise: the momentum of the image that is as short up to about the first place where this one is no longer.
    """

    is_shortest: np.ndarray
    image: Array


def cut_points(moments: Array, momentum: Array) -> CutPoints:
    """Find out whether geodesics from the identity are the shortest, by their moments and momenta, shape=[n, 3]."""
    found = CutPoints(np.empty(len(moments), dtype=bool), np.empty((len(moments), 3)))

    def run(part: slice) -> None:
        for begin in range(part.start, part.stop, _PART):
            own = slice(begin, min(begin + _PART, part.stop))
            _look(moments[own], momentum[own], CutPoints(*(values[own] for values in found)))

    in_threads(run, len(moments))
    return found


def _look(moments: Array, momentum: Array, found: CutPoints) -> None:
    signs, noise, body = _signs(moments, momentum)
    # in a plane of symmetry a product is 0 all the way; nearby geodesics on both sides of it say what it hides
    hidden = np.asarray((signs <= noise).all(axis=1))
    hidden[:, 3] = False
    index = np.flatnonzero(hidden.any(axis=-1))
    if len(index):
        sizes = np.linalg.norm(momentum[index], axis=-1, keepdims=True)
        nudged = momentum[index] + _NUDGE * sizes * hidden[index, :3]
        near = _signs(moments[index], nudged)
        for mine, new in zip((signs, noise), near, strict=False):
            mine[index] = np.where(hidden[index, None], new, mine[index])
    crossed = signs < -noise
    found.is_shortest[:] = ~crossed.any(axis=(1, 2))
    sample, every = crossed.any(axis=-1).argmax(axis=-1), np.arange(len(moments))
    which = crossed[every, sample].argmax(axis=-1)
    found.image[:] = -((sample + 1) / _SAMPLES)[:, None] * _IMAGES[which] * body[every, sample]


def _signs(moments: Array, momentum: Array) -> tuple[Array, Array, Array]:
    """Return x_i(t) M_i(t / 2) / |m| and w(t), what of them is rounding, shape=[n, _SAMPLES, 4], and M(t)."""
    turn, body = states(moments, momentum, np.arange(1, 2 * _SAMPLES + 1) / (2 * _SAMPLES))
    size = np.linalg.norm(momentum, axis=-1)[:, None, None]
    half = body[:, :_SAMPLES] / np.where(size > 0.0, size, 1.0)
    turn, body = turn[:, 1::2], body[:, 1::2]
    signs, noise = turn.copy(), np.full(turn.shape, _ROUNDING)
    signs[..., :3] *= half
    noise[..., :3] *= np.abs(turn[..., :3]) + np.abs(half)
    return signs, noise, body


def states(moments: Array, momentum: Array, parameter: Array) -> tuple[Array, Array]:
    """Evaluate geodesics of left-invariant metrics with diagonal matrices.

    Parameters
    ----------
    moments, momentum : array-like, shape=[n, 3]
    parameter : array-like, shape=[S]
        Increasing; 1 at the end of the geodesics.

    Returns
    -------
    turn : array-like, shape=[n, S, 4]
        Unit quaternions, the same way round as along the geodesic.
    body : array-like, shape=[n, S, 3]
        Body momentum.
    """
    n, n_samples = len(moments), len(parameter)
    inverse, momentum = 1.0 / moments, np.array(momentum, order="C")
    every, first = np.tile(parameter, n), np.arange(n) * n_samples
    turn, column = np.empty((n * n_samples, 1, 4)), np.zeros(n, dtype=np.intp)

    def run(part: slice) -> None:
        playback(inverse[part], momentum[part], first[part], first[part] + n_samples, every, column[part], turn)

    in_threads(run, n)
    turn = turn.reshape(n, n_samples, 4)
    return turn, quat.rotate(quat.conjugate(turn), momentum[:, None])
