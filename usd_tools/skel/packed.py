"""Packed motion in USD: the attribute of a SkelAnimation that holds it, and its samples on the stage's clock."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, Vt

from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import CHANNELS, Channel

PACKED = "geomstatsAnim:packed"
"""Custom uniform uchar[] of a SkelAnimation, or string in base85 (RFC 1924) where the file is text: its motion, packed.

Times in it are time codes. Attributes that it holds have samples at the first and the last of them, by which a layer
offset is seen, and at value blocks.
"""

WEIGHTS = "blendShapeWeights"


class PackedMotion(NamedTuple):
    """Hold what a SkelAnimation stores of its packed motion.

    Attributes
    ----------
    stream : bytes
    codes : array-like, shape=[F]
        Time codes of its frames, on the stage.
    has_others : bool
        Whether it holds more than joints.
    """

    stream: bytes
    codes: np.ndarray
    has_others: bool


class StoredStream(NamedTuple):
    """Hold packed motion, and whether the file that it goes to is text."""

    stream: bytes
    as_text: bool


def write_packed(spec: Sdf.PrimSpec, stream: bytes, as_text: bool) -> None:
    """Write packed motion on a SkelAnimation."""
    if PACKED in spec.attributes:
        spec.RemoveProperty(spec.attributes[PACKED])
    kind = Sdf.ValueTypeNames.String if as_text else Sdf.ValueTypeNames.UCharArray
    attribute = Sdf.AttributeSpec(spec, PACKED, kind, Sdf.VariabilityUniform)
    attribute.custom = True
    if as_text:
        attribute.default = base64.b85encode(stream).decode("ascii")
    else:
        attribute.default = Vt.UCharArray.FromNumpy(np.frombuffer(stream, dtype=np.uint8))


def remove_packed(spec: Sdf.PrimSpec, prim: Usd.Prim) -> None:
    """Remove packed motion from the spec of a prim that gets samples, and block that of weaker layers."""
    n_specs = len(prim.GetAttribute(PACKED).GetPropertyStack()) if prim.HasAttribute(PACKED) else 0
    own = spec.attributes.get(PACKED)
    if own is not None:
        spec.RemoveProperty(own)
        n_specs -= 1
    if n_specs > 0:
        attribute = Sdf.AttributeSpec(spec, PACKED, prim.GetAttribute(PACKED).GetTypeName(), Sdf.VariabilityUniform)
        attribute.custom, attribute.default = True, Sdf.ValueBlock()


def is_packed(prim: Usd.Prim) -> bool:
    """Return whether a SkelAnimation holds packed motion, and no stronger layer has samples over it."""
    attribute = prim.GetAttribute(PACKED)
    if not attribute or attribute.Get() is None:
        return False
    strongest = next(spec for spec in prim.GetPrimStack() if PACKED in spec.attributes or _has_samples(spec))
    return PACKED in strongest.attributes


def packed_layer(prim: Usd.Prim) -> Sdf.Layer:
    """Return the layer that the packed motion of a SkelAnimation comes from."""
    return next(spec.layer for spec in prim.GetPrimStack() if PACKED in spec.attributes)


def _has_samples(spec: Sdf.PrimSpec) -> bool:
    return any(
        name in spec.attributes and spec.layer.GetNumTimeSamplesForPath(spec.attributes[name].path) for name in CHANNELS
    )


def packed_bytes(prim: Usd.Prim) -> int | None:
    """Return the size of the packed motion of a SkelAnimation; None if it has none."""
    return len(_read_stream(prim)) if is_packed(prim) else None


def read_packed(prim: Usd.Prim, channels: Mapping[str, Channel]) -> PackedMotion | None:
    """Read the packed motion of a SkelAnimation; None if it has none.

    Parameters
    ----------
    prim : Usd.Prim
    channels : mapping of str to Channel
        What is sampled beside it.

    Raises
    ------
    ToolError
        If it cannot be used.
    """
    if not is_packed(prim):
        return None
    from geomstats_anim.codec.stream import StreamError, read_stream

    stream = _read_stream(prim)
    try:
        header = read_stream(stream)[0]
    except StreamError as error:
        raise ToolError(f"{prim.GetPath()}: {PACKED} cannot be read: {error}") from error
    codes = header.times
    sampled = [channel.codes for channel in channels.values() if len(channel.codes)]
    if not len(codes) or not sampled or not (np.isfinite(codes).all() and (np.diff(codes) > 0.0).all()):
        raise ToolError(
            f"{prim.GetPath()}: {PACKED} needs increasing times, and samples of the prim at the first and the last of "
            "them; pack the source again."
        )
    return PackedMotion(stream, _on_stage(codes, np.concatenate(sampled)), bool(header.channels))


def _read_stream(prim: Usd.Prim) -> bytes:
    value = prim.GetAttribute(PACKED).Get()
    if isinstance(value, Vt.UCharArray):
        return np.array(value).tobytes()
    try:
        return base64.b85decode(value)
    except (TypeError, ValueError) as error:
        raise ToolError(
            f"{prim.GetPath()}: {PACKED} must be a uchar[], or a string in base85; pack the source again."
        ) from error


def _on_stage(codes: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Move time codes as layer offsets have moved the samples, of which the first and the last are among them."""
    first, last = samples.min(), samples.max()
    if first == codes[0] and last == codes[-1]:
        return codes
    stretch = (last - first) / (codes[-1] - codes[0]) if codes[-1] > codes[0] else 1.0
    moved = first + (codes - codes[0]) * stretch
    moved[-1] = last
    return moved
