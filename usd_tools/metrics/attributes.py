"""Read and write the metric in a USD file: attributes on the SkelAnimation, and its summary in one line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from pxr import Sdf, Usd, Vt

from geomstats_anim import LearnedMetric, MetricParameters
from geomstats_anim.learned_metric import FORMAT_VERSION
from geomstats_anim.names import WITH_METRIC
from geomstats_anim.strict_json import dump_json, parse_json
from usd_tools.console.errors import ToolError
from usd_tools.console.text import counted
from usd_tools.metrics.schema import apply_schema, register_schema

register_schema()

NAMESPACE = "geodesicMetric"

_TYPES = {
    "joints": Sdf.ValueTypeNames.TokenArray,
    "alpha": Sdf.ValueTypeNames.DoubleArray,
    "beta": Sdf.ValueTypeNames.DoubleArray,
    "tension": Sdf.ValueTypeNames.DoubleArray,
    "translationTension": Sdf.ValueTypeNames.DoubleArray,
    "axes": Sdf.ValueTypeNames.Double3Array,
    "invariance": Sdf.ValueTypeNames.TokenArray,
    "scheme": Sdf.ValueTypeNames.Token,
    "version": Sdf.ValueTypeNames.Int,
}
SOURCE_CODES = f"{NAMESPACE}:sourceTimeCodes"
"""Of a sparse animation: where its source had samples."""

SOURCE_CUTS = f"{NAMESPACE}:sourceCuts"
"""Of a sparse animation: between which samples of its source cuts are, as pairs of indices into `SOURCE_CODES`."""

_OPTIONAL = ("axes", "translationTension")
_PROVENANCE = "provenance"
"""Entry of the customData: JSON, for USD has no null, and no lists of different types."""


def write_metric(spec: Sdf.PrimSpec, metric: LearnedMetric, hide_axes: bool = False) -> None:
    """Write a metric on a SkelAnimation.

    Parameters
    ----------
    spec : Sdf.PrimSpec
        Of the layer to be written.
    metric : LearnedMetric
    hide_axes : bool
        Whether a weaker layer has axes, which must not show through a diagonal metric.
        Optional, default: False.

    Raises
    ------
    ToolError
        If the metric couples joints.
    """
    parameters = uncoupled(metric, str(spec.path)).parameters
    values = {
        "joints": Vt.TokenArray(metric.joints),
        "alpha": Vt.DoubleArray.FromNumpy(parameters.alpha),
        "beta": Vt.DoubleArray.FromNumpy(parameters.beta),
        "tension": Vt.DoubleArray.FromNumpy(metric.tension),
        "translationTension": Vt.DoubleArray.FromNumpy(metric.translation_tension),
        "invariance": Vt.TokenArray(parameters.invariance),
        "scheme": metric.scheme,
        "version": FORMAT_VERSION,
    }
    if parameters.axes is not None:
        values["axes"] = Vt.Vec3dArray.FromNumpy(parameters.axes)
    elif hide_axes:
        values["axes"] = Sdf.ValueBlock()
    for name, value in values.items():
        _attribute(spec, f"{NAMESPACE}:{name}", _TYPES[name], custom=False).default = value
    apply_schema(spec)
    # One string: USD merges the dictionaries of layers, and entries of an older metric would show through.
    entries = {"quality": metric.quality, _PROVENANCE: dump_json(dict(metric.provenance))}
    spec.customData = {**dict(spec.customData), NAMESPACE: entries}


def uncoupled(metric: LearnedMetric, where: str) -> LearnedMetric:
    """Return a metric, unless it couples joints, which the attributes cannot hold.

    Raises
    ------
    ToolError
    """
    if metric.coupling is not None:
        raise ToolError(f"{where}: the metric couples joints, which only Python can use; learn the family spd instead.")
    return metric


def summary(metric: LearnedMetric) -> str:
    """Describe a metric in one line, and a scheme that uses none by its name."""
    parameters = metric.parameters
    if not metric.joints:
        return "no joints"
    if metric.scheme not in WITH_METRIC:
        return f"{metric.scheme}, {counted(len(metric.joints), 'joint')}"
    sides = [f"{parameters.invariance.count(side)} {side}" for side in ("left", "right")]
    family = "diagonal" if parameters.axes is None else "spd"
    words = [metric.scheme, f"{counted(len(metric.joints), 'joint')} ({', '.join(sides)})", family]
    words += [_range("alpha", parameters.alpha), _range("beta", parameters.beta)]
    if metric.tension.any():
        words.append(_range("tension", metric.tension))
    return ", ".join(words)


def _range(name: str, values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{name} {low:.4g}" if low == high else f"{name} {low:.4g} to {high:.4g}"


def read_metric(prim: Usd.Prim) -> LearnedMetric | None:
    """Read the metric of a SkelAnimation.

    Parameters
    ----------
    prim : Usd.Prim

    Returns
    -------
    metric : LearnedMetric or None
        None if there is none.

    Raises
    ------
    ToolError
        If an attribute is missing, has the wrong type or size, or makes no metric.
    """
    values = _values(prim)
    if all(value is None for value in values.values()):
        return None
    for fault in _faults(prim, values):
        raise ToolError(fault)
    axes = values["axes"]
    try:
        stored = prim.GetCustomDataByKey(NAMESPACE)
        quality, provenance = _read_entries(stored if isinstance(stored, Mapping) else {})
        parameters = MetricParameters(
            np.array(values["alpha"]),
            np.array(values["beta"]),
            None if axes is None else np.array(axes),
            tuple(values["invariance"]),
        )
        return LearnedMetric(
            tuple(values["joints"]),
            parameters,
            np.array(values["tension"]),
            str(values["scheme"]),
            quality,
            provenance,
            values["translationTension"] and np.array(values["translationTension"]),
        )
    except ValueError as error:
        raise ToolError(f"{prim.GetPath()}: the stored metric is invalid: {error}") from error


def metric_faults(prim: Usd.Prim) -> list[str]:
    """Return what is wrong with the attributes of a metric, a sentence each; empty where there are none."""
    values = _values(prim)
    return [] if all(value is None for value in values.values()) else list(_faults(prim, values))


def _values(prim: Usd.Prim) -> dict[str, Any]:
    return {name: prim.GetAttribute(f"{NAMESPACE}:{name}").Get() for name in _TYPES}


def _faults(prim: Usd.Prim, values: Mapping[str, Any]) -> Iterator[str]:
    version = values["version"]
    if version is not None and version != FORMAT_VERSION:
        yield f"{prim.GetPath()}: {NAMESPACE}:version is {version}, but this program reads {FORMAT_VERSION}; update it."
    for name, value in values.items():
        if value is None:
            if name not in _OPTIONAL:
                yield f"{prim.GetPath()}: {NAMESPACE}:{name} is missing; write the whole metric, or remove it."
            continue
        # The attribute itself has the schema's type, whatever a layer says.
        type_name = prim.GetAttribute(f"{NAMESPACE}:{name}").GetPropertyStack()[0].typeName
        if type_name != _TYPES[name]:
            yield f"{prim.GetPath()}: {NAMESPACE}:{name} has type {type_name}; it must have type {_TYPES[name]}."
        elif _TYPES[name].isArray and values["joints"] is not None and len(value) != len(values["joints"]):
            yield f"{prim.GetPath()}: {NAMESPACE}:{name} has {len(value)} values for {len(values['joints'])} joints."


def write_source_codes(spec: Sdf.PrimSpec, codes: np.ndarray, cuts: np.ndarray | None = None) -> None:
    """Write on a SkelAnimation what its source had.

    Parameters
    ----------
    spec : Sdf.PrimSpec
    codes : array-like, shape=[F]
        Time codes of the samples.
    cuts : array-like, shape=[C, 2]
        Time codes of the samples on both sides of each cut.
        Optional, default: None, nothing is said of them.
    """
    _attribute(spec, SOURCE_CODES, Sdf.ValueTypeNames.DoubleArray).default = Vt.DoubleArray.FromNumpy(codes)
    if cuts is not None:
        pairs = Vt.Vec2iArray.FromNumpy(np.searchsorted(codes, cuts).astype(np.int32))
        _attribute(spec, SOURCE_CUTS, Sdf.ValueTypeNames.Int2Array).default = pairs


def hide_source_codes(spec: Sdf.PrimSpec) -> None:
    """Block what weaker layers store of the source of a sparse SkelAnimation."""
    _attribute(spec, SOURCE_CODES, Sdf.ValueTypeNames.DoubleArray).default = Sdf.ValueBlock()


def read_source_codes(prim: Usd.Prim) -> np.ndarray | None:
    """Read the time codes at which the source of a sparse SkelAnimation had samples; None if it is not sparse.

    Raises
    ------
    ToolError
        If they are not increasing numbers.
    """
    value = prim.GetAttribute(SOURCE_CODES).Get()
    if value is None:
        return None
    codes = np.array(value, dtype=np.float64) if isinstance(value, Vt.DoubleArray) else np.zeros(0)
    if not (len(codes) and np.isfinite(codes).all() and (np.diff(codes) > 0.0).all()):
        raise ToolError(f"{prim.GetPath()}: {SOURCE_CODES} must hold increasing numbers (double[]); repair the file.")
    return codes


def read_source_cuts(prim: Usd.Prim, n_codes: int) -> np.ndarray:
    """Read between which samples of the source of a sparse SkelAnimation there are cuts, shape=[C, 2], as indices.

    Raises
    ------
    ToolError
        If they are not increasing indices of the source's samples.
    """
    value = prim.GetAttribute(SOURCE_CUTS).Get()
    if value is None:
        return np.zeros((0, 2), dtype=np.intp)
    cuts = np.array(value, dtype=np.intp) if isinstance(value, Vt.Vec2iArray) else np.zeros((1, 2), dtype=np.intp)
    before, after = cuts.T
    if not ((before >= 0).all() and (before < after).all() and (after < n_codes).all()):
        raise ToolError(
            f"{prim.GetPath()}: {SOURCE_CUTS} must hold pairs of increasing indices of {SOURCE_CODES} (int2[]); repair "
            "the file."
        )
    return cuts


def _attribute(spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, custom: bool = True) -> Sdf.AttributeSpec:
    attribute = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, type_name)
    attribute.custom = custom
    return attribute


def _read_entries(entries: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Read the quality and the provenance of a metric; both are empty in a file that has lost them."""
    texts = {name: entries.get(name, default) for name, default in (("quality", ""), (_PROVENANCE, "{}"))}
    for name, text in texts.items():
        if not isinstance(text, str):
            raise ValueError(f"{name} of its customData has a type that metrics do not use; remove it.")
    provenance = parse_json(texts[_PROVENANCE])
    if not isinstance(provenance, dict):
        raise ValueError(f"{_PROVENANCE} of its customData is not a JSON object; remove it.")
    return texts["quality"], provenance
