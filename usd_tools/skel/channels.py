"""Read and write the samples of one attribute of a SkelAnimation, bit for bit as they are in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from pxr import Sdf, Usd, Vt

from usd_tools.console.errors import ToolError

JOINT_CHANNELS = ("rotations", "translations", "scales")
"""Channels of which every joint has one element."""

STEP_SECONDS = 1e-3
"""Two samples nearer than this are a step: nothing is recorded at more than 1000 samples per second, but stepped keys
are authored as one sample just before the change and one at its time."""

STEP_SHARE = 0.1
"""A step is also shorter than this share of the pause before or after it."""

VALUE_CLIPS = "value clips"
"""Source of samples that USD takes from several files, one after the other."""


@dataclass(frozen=True)
class ChannelType:
    """Storage of an attribute: USD's type, numbers per element, type in NumPy."""

    value_type: Sdf.ValueTypeName
    array: Any
    width: int
    dtype: type

    def to_numpy(self, value: Any) -> np.ndarray:
        """Convert a value of USD to an array, shape=[N, width]."""
        return np.array(value, dtype=self.dtype).reshape(-1, self.width)

    def to_usd(self, values: np.ndarray) -> Any:
        """Convert an array, shape=[N, width], to a value of USD."""
        return self.array.FromNumpy(values[:, 0] if self.width == 1 else values)


CHANNELS = {
    "rotations": ChannelType(Sdf.ValueTypeNames.QuatfArray, Vt.QuatfArray, 4, np.float32),
    "translations": ChannelType(Sdf.ValueTypeNames.Float3Array, Vt.Vec3fArray, 3, np.float32),
    "scales": ChannelType(Sdf.ValueTypeNames.Half3Array, Vt.Vec3hArray, 3, np.float16),
    "blendShapeWeights": ChannelType(Sdf.ValueTypeNames.FloatArray, Vt.FloatArray, 1, np.float32),
}
"""The attributes of a SkelAnimation that move. NumPy sees quaternions as (x, y, z, w)."""


@dataclass(frozen=True, eq=False)
class Channel:
    """Samples of one attribute.

    Parameters
    ----------
    name : str
        A key of `CHANNELS`.
    codes : array-like, shape=[K]
        Time codes of the stage, increasing; none if there is only a default value.
    values : array-like, shape=[K, N, C]
        In the file's own precision. Where a sample is blocked: zeros.
    blocked : array-like of bool, shape=[K]
        Which samples are value blocks.
    default : array-like, shape=[N, C]
        Value that holds where there are no samples: the earliest sample, else the authored default.
    source : str
        Where the samples come from: the name of a layer, `VALUE_CLIPS`, or "" if there are none.
    """

    name: str
    codes: np.ndarray
    values: np.ndarray
    blocked: np.ndarray
    default: np.ndarray
    source: str

    @property
    def spans(self) -> list[slice]:
        """Stretches of samples without a value block, of at least two samples each."""
        edges = np.diff(np.concatenate([[1], self.blocked.astype(np.intp), [1]]))
        starts, stops = np.flatnonzero(edges == -1), np.flatnonzero(edges == 1)
        return [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True) if b - a > 1]

    def stretches(self, codes_per_second: float, cuts: np.ndarray) -> list[slice]:
        """Return the spans, parted where two samples are a step, or where a gap is in a cut, shape=[C, 2]."""
        stretches = []
        for span in self.spans:
            jumps = step_pairs(self.codes[span], codes_per_second)
            for before, after in cuts:
                jumps |= (self.codes[span][:-1] >= before) & (self.codes[span][1:] <= after)
            edges = [span.start, *(span.start + 1 + np.flatnonzero(jumps)).tolist(), span.stop]
            stretches += [slice(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b - a > 1]
        return stretches

    @property
    def is_animated(self) -> bool:
        """Return whether there is anything to interpolate."""
        return bool(self.spans)

    @cached_property
    def holds(self) -> np.ndarray:
        """Return whether each element stays as it is from one sample to the next, bit for bit, shape=[K - 1, N].

        A quaternion and its negative are the same rotation.
        """
        left, right = self.values[:-1], self.values[1:]
        same = (left == right).all(axis=-1)
        return same | (left == -right).all(axis=-1) if self.name == "rotations" else same

    @cached_property
    def squares(self) -> np.ndarray:
        """Return the squared length of each element, shape=[K, N], in single precision at least."""
        dtype = np.result_type(self.values, np.float32)
        return np.einsum("knc,knc->kn", self.values, self.values, dtype=dtype)

    @cached_property
    def is_finite(self) -> np.ndarray:
        """Return whether each element is of finite numbers, shape=[K, N]."""
        finite = np.isfinite(self.squares)
        return finite if finite.all() else np.isfinite(self.values).all(axis=-1)

    @property
    def is_constant(self) -> bool:
        """Return whether every sample is the same, bit for bit, and none is blocked."""
        return not self.blocked.any() and bool(self.holds.all())

    def at(self, kept: np.ndarray) -> Channel:
        """Return the channel with some of its samples: a mask or their indices."""
        return replace(self, codes=self.codes[kept], values=self.values[kept], blocked=self.blocked[kept])


def held(channel: Channel, codes: np.ndarray) -> Channel:
    """Hold every sample of a channel until the next, and the first one before; value blocks block, and stay alone."""
    last = np.maximum(np.searchsorted(channel.codes, codes, side="right") - 1, 0)
    kept = ~channel.blocked[last] | np.isin(codes, channel.codes)
    last = last[kept]
    return replace(channel, codes=codes[kept], values=channel.values[last], blocked=channel.blocked[last])


def sampled_alike(channels: Mapping[str, Channel]) -> list[tuple[str, ...]]:
    """Group channels that have the same samples and blocks."""
    groups: dict[tuple[object, ...], list[str]] = {}
    for name, channel in channels.items():
        groups.setdefault((channel.codes.tobytes(), channel.blocked.tobytes()), []).append(name)
    return [tuple(names) for names in groups.values()]


def write_samples(spec: Sdf.AttributeSpec, channel: Channel, offset: Sdf.LayerOffset | None = None) -> None:
    """Write the samples of a channel, and no others, to an attribute; an offset maps time codes to the layer's."""
    kind = CHANNELS[channel.name]
    write_values(spec, channel, [kind.to_usd(values) for values in channel.values], offset)


def write_values(
    spec: Sdf.AttributeSpec, channel: Channel, values: Sequence[Any], offset: Sdf.LayerOffset | None = None
) -> None:
    """Write values of USD at the time codes of a channel, blocks where it has blocks; see `write_samples`."""
    block = Sdf.ValueBlock()
    spec.ClearInfo("timeSamples")
    layer, path, codes = spec.layer, spec.path, channel.codes.tolist()
    if offset is not None and not offset.IsIdentity():
        codes = [_whole(offset * code) for code in codes]
    with Sdf.ChangeBlock():
        for code, value, is_blocked in zip(codes, values, channel.blocked, strict=True):
            layer.SetTimeSample(path, code, block if is_blocked else value)


def _whole(code: float) -> float:
    """Return a time code without the rounding error that an offset leaves of a whole one."""
    nearest = round(code)
    return float(nearest) if abs(code - nearest) <= 1e-12 * max(1.0, abs(code)) else code


def read_channel(prim: Usd.Prim, name: str, size: int, allows_gaps: bool = False) -> Channel | None:
    """Read an attribute of a SkelAnimation.

    Parameters
    ----------
    prim : Usd.Prim
    name : str
        A key of `CHANNELS`.
    size : int
        Elements that each sample must have, N.
    allows_gaps : bool
        Read samples whose numbers are not finite, too.
        Optional, default: False, they are refused.

    Returns
    -------
    channel : Channel or None
        None if it has no value at all.

    Raises
    ------
    ToolError
        If a value has another size, or a number in it is not finite.
    """
    kind, attribute = CHANNELS[name], prim.GetAttribute(name)
    try:
        codes, raw, source = read_samples(attribute)
    except TypeError as error:  # of a damaged file OpenUSD may give what Python has no type for
        raise ToolError(
            f"{prim.GetPath()}: {name} has a value of a type that attributes do not have; repair the file."
        ) from error
    values: np.ndarray = np.zeros((len(codes), size, kind.width), dtype=kind.dtype)
    blocked = np.zeros(len(codes), dtype=bool)
    for k, value in enumerate(raw):
        if value is None or isinstance(value, Sdf.ValueBlock):
            blocked[k] = True
        else:
            values[k] = _checked(prim, name, size, value, codes[k])
    live = np.flatnonzero(~blocked)
    if len(codes):
        default = values[live[0]] if len(live) else None
    else:
        value = attribute.Get() if attribute else None
        default = None if value is None else _checked(prim, name, size, value, None)
    if default is None:
        return None
    channel = Channel(name, np.array(codes, dtype=np.float64), values, blocked, default, source)
    if len(codes) and not allows_gaps and not channel.is_finite.all():
        code = codes[int(np.argmin(channel.is_finite.all(axis=-1)))]
        raise ToolError(
            f"{prim.GetPath()}: {name} has a value that is not a finite number at time code {code:g}; usd_tools.repair "
            "fills it in."
        )
    if not len(codes) and not np.isfinite(default).all():
        raise ToolError(f"{prim.GetPath()}: {name} has a value that is not a finite number; repair the file.")
    return channel


def read_samples(attribute: Usd.Attribute) -> tuple[list[float], list[Any], str]:
    """Read the time codes and values of an attribute's samples, and where they come from, as in `Channel`.

    Raises
    ------
    ToolError
        If no layer holds them.
    """
    codes = attribute.GetTimeSamples() if attribute else []
    if not codes:
        return [], [], ""
    if attribute.GetResolveInfo(codes[0]).GetSource() == Usd.ResolveInfoSourceValueClips:
        return codes, [attribute.Get(code) for code in codes], VALUE_CLIPS
    # Asking the layer, not the stage: a layer offset rounds time codes, and a sample that is missed by a rounding
    # error would be interpolated instead of being read bit for bit.
    for spec, offset in attribute.GetPropertyStackWithLayerOffsets(Usd.TimeCode.Default()):
        own = spec.layer.ListTimeSamplesForPath(spec.path)
        if own:
            pairs = [(offset * code, spec.layer.QueryTimeSample(spec.path, code)) for code in own]
            pairs.sort(key=lambda pair: pair[0])
            return [code for code, _ in pairs], [value for _, value in pairs], spec.layer.GetDisplayName()
    raise ToolError(f"{attribute.GetPath()}: OpenUSD lists samples that no layer holds; flatten the file first.")


def _checked(prim: Usd.Prim, name: str, size: int, value: Any, code: float | None) -> np.ndarray:
    kind = CHANNELS[name]
    at = "" if code is None else f" at time code {code:g}"
    if not isinstance(value, kind.array):
        raise ToolError(f"{prim.GetPath()}: {name}{at} is not of type {kind.value_type}; repair the file.")
    array = kind.to_numpy(value)
    if len(array) != size:
        of_what = "blendShapes" if name == "blendShapeWeights" else "joints"
        raise ToolError(f"{prim.GetPath()}: {name}{at} has {len(array)} values for {size} {of_what}; repair the file.")
    return array


def step_pairs(codes: np.ndarray, codes_per_second: float) -> np.ndarray:
    """Find the gaps between samples that are steps: too short to be motion.

    Parameters
    ----------
    codes : array-like, shape=[K]
    codes_per_second : float

    Returns
    -------
    is_step : array-like of bool, shape=[K - 1]
    """
    gaps = np.diff(codes)
    if len(gaps) < 2:
        return np.zeros(len(gaps), dtype=bool)
    padded = np.concatenate([[0.0], gaps, [0.0]])
    pause = np.maximum(padded[:-2], padded[2:])
    return (gaps < STEP_SECONDS * codes_per_second) & (gaps < STEP_SHARE * pause)
