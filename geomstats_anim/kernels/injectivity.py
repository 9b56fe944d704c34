"""Compiled bound of the injectivity radius of left-invariant metrics on SO(3)."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled


@compiled
def radii(moments, out):
    """Bound the length up to which every geodesic is the only shortest one; see `geodesics.shortest`.

    The curvatures are those of Milnor, "Curvatures of left invariant metrics on Lie groups", 1976, section 4.

    Parameters
    ----------
    moments : array-like, shape=[n, 3]
    out : array-like, shape=[n]
        Written.
    """
    for n in range(len(moments)):
        a, b, c = moments[n]
        root = np.sqrt(a * b * c)
        x, y, z = a / root, b / root, c / root
        half = 0.5 * (x + y + z)
        p, q, r = half - x, half - y, half - z
        curvature = max(x * p - q * r, y * q - r * p, z * r - p * q)
        out[n] = min(np.pi / np.sqrt(curvature), np.pi * np.sqrt(min(a, b, c)))
