"""Which frames to keep as keys."""

from __future__ import annotations

import numpy as np


def uniform_keyframes(n_frames: int, rate: float) -> np.ndarray:
    """Choose equally spaced keys, as the papers do (Kushner, Modi, Miolane, section 4.1).

    Parameters
    ----------
    n_frames : int
        Frames of the animation, F.
    rate : float
        Share of the frames to keep, in (0, 1].

    Returns
    -------
    indices : array-like of int, shape=[K]
        max(2, round(rate F)) indices, equally spaced up to rounding, the first and the last frame included.

    Raises
    ------
    ValueError
        If there are fewer than two frames, or the rate is outside (0, 1].

    Examples
    --------
    >>> from geomstats_anim import uniform_keyframes
    >>> uniform_keyframes(10, 0.4)
    array([0, 3, 6, 9])
    """
    if n_frames < 2:
        raise ValueError(f"Keys need at least 2 frames, but there are {n_frames}.")
    if not 0.0 < rate <= 1.0:
        raise ValueError(f"The rate must be above 0 and at most 1, but it is {rate}.")
    n_keys = max(2, round(rate * n_frames))
    return np.round(np.linspace(0, n_frames - 1, n_keys)).astype(np.intp)
