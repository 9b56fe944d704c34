"""Bytes against largest error: packed motion, few keys, and samples rounded and compressed."""

from __future__ import annotations

import lzma
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from geomstats_anim import Animation, compress, interpolate, uniform_keyframes
from geomstats_anim.codec import pack, unpack
from geomstats_anim.keyframes.problem import by_halving
from geomstats_anim.markers import Markers, joint_matrices, world_errors
from geomstats_anim.rotations import normalize
from usd_tools.comparison.acl import ACL, acl_bytes
from usd_tools.skel.sizes import bytes_numpy

_FINEST = 2.0**-24
"""Least step of rounding, of quaternions; single precision has no less."""

_STEPS = 96
"""Steps of rounding that are tried, a quarter octave apart."""

_LZMA = ({"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME},)


@dataclass(frozen=True)
class RateDistortion:
    """One point of a curve of bytes against error.

    Parameters
    ----------
    clip : str
    method : str
        A key of `METHODS`, or `ACL`.
    tolerance_cm : float
        What was asked for.
    bytes : int or None
        Of motion alone; None where the method cannot keep the tolerance.
    largest_cm, mean_cm : float or None
        Errors of joints, bone ends and shell in the world; None where nothing was decoded.
    share : float or None
        Of the bytes of the samples as they are, as the papers count.
    """

    clip: str
    method: str
    tolerance_cm: float
    bytes: int | None
    largest_cm: float | None
    mean_cm: float | None
    share: float | None


class Encoded(NamedTuple):
    """Hold bytes, and the motion that they stand for."""

    size: int
    decoded: Sequence[Animation]


def rate_distortion(clip: str, method: str, stretches: Sequence[Animation], tolerance: float) -> RateDistortion:
    """Encode a clip by a method within a tolerance, centimetres, and measure what comes back.

    Parameters
    ----------
    clip : str
    method : str
        A key of `METHODS`.
    stretches : sequence of Animation
    tolerance : float
    """
    try:
        encoded = METHODS[method](stretches, 0.01 * tolerance)
    except ValueError:
        return RateDistortion(clip, method, tolerance, None, None, None, None)
    errors = 100.0 * np.concatenate(
        [
            world_errors(ours, truth, Markers.of_shell(truth))
            for ours, truth in zip(encoded.decoded, stretches, strict=True)
        ]
    )
    share = encoded.size / bytes_numpy(stretches, None)
    return RateDistortion(clip, method, tolerance, encoded.size, float(errors.max()), float(errors.mean()), share)


def acl_reference(clip: str, stretches: Sequence[Animation], tolerance: float) -> RateDistortion | None:
    """Return the bytes of ACL for a clip within a tolerance, centimetres; None if they are not known."""
    size = acl_bytes(stretches, tolerance)
    if size is None:
        return None
    return RateDistortion(clip, ACL, tolerance, size, None, None, size / bytes_numpy(stretches, None))


def _packed(stretches: Sequence[Animation], tolerance: float) -> Encoded:
    streams = [pack(each, tolerance) for each in stretches]
    decoded = [unpack(stream, each.skeleton) for stream, each in zip(streams, stretches, strict=True)]
    return Encoded(sum(map(len, streams)), decoded)


def _downsampled(stretches: Sequence[Animation], tolerance: float) -> Encoded:
    found = compress(stretches, tolerance=tolerance, markers=Markers.of_shell(stretches[0]))
    keys = [each.at_frames(frames) for each, frames in zip(stretches, found.keyframes, strict=True)]
    decoded = [
        interpolate(each, truth.times, found.metric.scheme, found.metric)
        for each, truth in zip(keys, stretches, strict=True)
    ]
    return Encoded(bytes_numpy(keys, found.metric), decoded)


def _uniform_slerp(stretches: Sequence[Animation], tolerance: float) -> Encoded:
    n_frames = sum(each.n_frames for each in stretches)

    def encoded(number: int) -> Encoded:
        keys = [each.at_frames(uniform_keyframes(each.n_frames, number / n_frames)) for each in stretches]
        decoded = [interpolate(few, each.times, "slerp") for few, each in zip(keys, stretches, strict=True)]
        return Encoded(bytes_numpy(keys, None), decoded)

    return encoded(by_halving(lambda number: _is_within(encoded(number), stretches, tolerance), 0, n_frames))


def _rounded(stretches: Sequence[Animation], tolerance: float) -> Encoded:
    """Round quaternions and translations to the coarsest step that will do, and compress differences in time."""
    reach = _reach(stretches)

    def decoded(number: int) -> list[Animation]:
        return [_round(each, _FINEST * 2.0 ** ((_STEPS - number) / 4.0), reach)[1] for each in stretches]

    number = by_halving(lambda number: _is_within(Encoded(0, decoded(number)), stretches, tolerance), -1, _STEPS + 1)
    if number > _STEPS:
        raise ValueError("no step is fine enough")
    step = _FINEST * 2.0 ** ((_STEPS - number) / 4.0)
    parts = [_round(each, step, reach) for each in stretches]
    data = b"".join(_planes(np.diff(integers, axis=0, prepend=0)) for integers, _ in parts)
    return Encoded(len(lzma.compress(data, lzma.FORMAT_RAW, filters=_LZMA)), [animation for _, animation in parts])


def _reach(stretches: Sequence[Animation]) -> float:
    """Return metres that a step of translations is for one of quaternions: the size of the character."""
    first = joint_matrices(stretches[0].at_frames(slice(0, 1)))[0, :, :, 3]
    return float(np.linalg.norm(np.ptp(first, axis=0))) or 1.0


def _round(animation: Animation, step: float, reach: float) -> tuple[np.ndarray, Animation]:
    """Return integers, shape=[F, 7 B or more], and the motion that they stand for."""
    scales = [] if animation.scales is None else [animation.scales / step]
    parts = [animation.rotations / step, animation.translations / (step * reach), *scales]
    whole = [np.rint(part) for part in parts]
    rounded = replace(
        animation,
        rotations=normalize(whole[0] * step),
        translations=whole[1] * (step * reach),
        scales=whole[2] * step if scales else None,
    )
    return np.concatenate([part.reshape(animation.n_frames, -1) for part in whole], axis=1).astype(np.int64), rounded


def _planes(differences: np.ndarray) -> bytes:
    """Lay out integers channel by channel, lowest bytes first, the sign in the lowest bit."""
    folded = np.where(differences < 0, -2 * differences - 1, 2 * differences).T.astype("<u4")
    return np.ascontiguousarray(folded).view(np.uint8).reshape(-1, 4).T.tobytes()


def _is_within(encoded: Encoded, stretches: Sequence[Animation], tolerance: float) -> bool:
    return all(
        world_errors(ours, truth, Markers.of_shell(truth)).max() <= tolerance
        for ours, truth in zip(encoded.decoded, stretches, strict=True)
    )


METHODS: dict[str, Callable[[Sequence[Animation], float], Encoded]] = {
    "pack": _packed,
    "rounded, LZMA": _rounded,
    "downsample": _downsampled,
    "uniform slerp": _uniform_slerp,
}
"""Ways to keep motion in few bytes: `pack`; samples rounded to one step, differences in time through LZMA; `downsample`
and, as in the papers, equally spaced samples for slerp, both as NumPy files."""
