"""Count the bytes of a clip's kept samples, and of the metric that rebuilds the others."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np
from pxr import Sdf, Vt

from geomstats_anim import Animation, LearnedMetric
from usd_tools.files.openusd_errors import TEMPORARY
from usd_tools.metrics.attributes import write_metric, write_source_codes
from usd_tools.skel.channels import CHANNELS, write_samples
from usd_tools.skel.clip import SkelClip

COMPARING = (
    "Ratios compare bytes at these errors, and nothing else: codecs for engines, such as ACL, decode single poses in "
    "place in nanoseconds; this unpacks a whole clip in milliseconds."
)
"""Said wherever bytes are compared."""


def bytes_numpy(keys: Sequence[Animation], metric: LearnedMetric | None) -> int:
    """Count bytes as the papers do: the sum of the sizes of NumPy files.

    They are the rotations as quaternions and the translations of all joints, and of a metric each array of parameters;
    float32, sides as one byte per joint.

    Parameters
    ----------
    keys : sequence of Animation
        Kept frames.
    metric : LearnedMetric or None

    Returns
    -------
    size : int
    """
    arrays = [np.concatenate([getattr(part, name) for part in keys]) for name in ("rotations", "translations")]
    files = [array.astype(np.float32) for array in arrays]
    return sum(_npy_size(array) for array in files + _metric_arrays(metric))


def clip_bytes_numpy(clip: SkelClip, metric: LearnedMetric | None) -> int:
    """Count bytes as `bytes_numpy` does, for a clip as it is: a channel without samples is one value."""
    arrays = [channel.values if len(channel.codes) else channel.default for channel in clip.channels.values()]
    return sum(_npy_size(array) for array in arrays + _metric_arrays(metric))


def _metric_arrays(metric: LearnedMetric | None) -> list[np.ndarray]:
    if metric is None:
        return []
    # fields, not all that is kept with them for speed
    values = [getattr(each, field.name) for each in (metric, metric.parameters) for field in fields(each)]
    # the scheme says that there is no tension
    arrays = [value for value in values if isinstance(value, np.ndarray) and value.any()]
    return [array.astype(np.float32) for array in arrays] + [metric.parameters.is_right]


def _npy_size(array: np.ndarray) -> int:
    file = io.BytesIO()
    np.save(file, array)
    return file.tell()


def bytes_usdc(keys: Sequence[Animation], metric: LearnedMetric | None) -> int:
    """Return the size of a usdc file that holds one SkelAnimation with the kept samples, and its metric.

    Parameters
    ----------
    keys : sequence of Animation
        Kept frames.
    metric : LearnedMetric or None

    Returns
    -------
    size : int
    """
    layer, prim = _animation(keys[0].skeleton.joints)
    for name in ("rotations", "translations", "scales"):
        kind = CHANNELS[name]
        attribute = Sdf.AttributeSpec(prim, name, kind.value_type)
        if getattr(keys[0], name) is None:
            attribute.default = kind.to_usd(np.ones((keys[0].n_joints, kind.width), dtype=kind.dtype))
            continue
        with Sdf.ChangeBlock():
            for part in keys:
                for time, values in zip(part.times.tolist(), getattr(part, name), strict=True):
                    layer.SetTimeSample(attribute.path, time, kind.to_usd(values.astype(kind.dtype)))
    return _usdc_size(layer, prim, metric)


def clip_bytes_usdc(clip: SkelClip, metric: LearnedMetric | None, source_codes: np.ndarray | None) -> int:
    """Return the size of a usdc file that holds a clip's SkelAnimation alone, as it is.

    Parameters
    ----------
    clip : SkelClip
    metric : LearnedMetric or None
    source_codes : array-like, shape=[F], or None
        Of a sparse clip: where its source had samples.

    Returns
    -------
    size : int
    """
    layer, prim = _animation(clip.joints)
    for name, channel in clip.channels.items():
        kind = CHANNELS[name]
        attribute = Sdf.AttributeSpec(prim, name, kind.value_type)
        if len(channel.codes):
            write_samples(attribute, channel)
        else:
            attribute.default = kind.to_usd(channel.default)
    if source_codes is not None:
        write_source_codes(prim, source_codes)
    return _usdc_size(layer, prim, metric)


def _animation(joints: Sequence[str]) -> tuple[Sdf.Layer, Sdf.PrimSpec]:
    """Make a layer, to be kept as long as its prim is used, and a SkelAnimation on it."""
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    prim = Sdf.PrimSpec(layer, "Animation", Sdf.SpecifierDef, "SkelAnimation")
    Sdf.AttributeSpec(prim, "joints", Sdf.ValueTypeNames.TokenArray).default = Vt.TokenArray(list(joints))
    return layer, prim


def _usdc_size(layer: Sdf.Layer, prim: Sdf.PrimSpec, metric: LearnedMetric | None) -> int:
    if metric is not None:
        write_metric(prim, metric)
    with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
        path = Path(folder) / "kept.usdc"
        layer.Export(str(path))
        return path.stat().st_size
