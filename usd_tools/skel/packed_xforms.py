"""Transform ops as columns of packed motion, and back."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from geomstats_anim.rotations import Array, make_continuous, normalize
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import Channel
from usd_tools.skel.packed import PACKED, packed_layer
from usd_tools.skel.xform_motion import Codec, Parts, codec_of
from usd_tools.skel.xform_ops import read_op

_PREFIX = "xformOp:"
"""Of the names of transform ops."""

_EQUAL = 1e-12
"""Share of themselves by which equal numbers may differ."""

_WIDTHS = dict(zip(Parts._fields, (4, 3, 3), strict=True))


def column_names(prim: Usd.Prim, attribute: Usd.Attribute, parts: Mapping[str, Array]) -> dict[str, Array]:
    """Name the columns of an op as seen from a SkelAnimation, so that they are found wherever both are referenced.

    The names are such as "..:translate" and "../Skel:transform turns".
    """
    path = attribute.GetPrimPath().MakeRelativePath(prim.GetPath())
    op = attribute.GetName().removeprefix(_PREFIX)
    return {f"{path}:{op} {part}".rstrip(): values for part, values in parts.items()}


def to_parts(attribute: Usd.Attribute, numbers: Array) -> dict[str, Array]:
    """Return columns to pack of numbers of an op, shape=[F, C].

    Matrices are a scale, a turn and a move, and remain so: of these, what never changes is left out.
    """
    codec = _matrix_codec(attribute, numbers)
    if codec is None:
        return {"": make_continuous(numbers) if _is_quaternion(attribute) else _narrowed(numbers)}
    parts = codec.split(numbers)
    parts = parts._replace(turns=make_continuous(parts.turns))
    moving = {name: _narrowed(values) for name, values in parts._asdict().items() if (values != values[0]).any()}
    return moving or {"path": parts.path}


def _narrowed(values: Array) -> Array:
    """Return one column of columns that are equal, such as even scales, so that they remain so."""
    return values[:, :1] if np.allclose(values, values[:, :1], rtol=_EQUAL, atol=0.0) else values


def from_parts(attribute: Usd.Attribute, parts: Mapping[str, Array], first: Array) -> Array:
    """Return the numbers of an op, shape=[F, C], that `to_parts` made columns of.

    Parameters
    ----------
    attribute : Usd.Attribute
    parts : mapping of str to array-like
    first : array-like, shape=[C]
        Its first sample, which has what never changes.

    Raises
    ------
    ValueError
        If they are not of such an op.
    """
    codec = _matrix_codec(attribute, first[None])
    widths = {"": len(first)} if codec is None else _WIDTHS
    if any(values.shape[1] not in (1, widths.get(part, 0)) for part, values in parts.items()):
        raise ValueError("it is packed as another kind of transform")
    parts = {part: np.broadcast_to(values, (len(values), widths[part])) for part, values in parts.items()}
    if codec is None:
        return normalize(parts[""]) if _is_quaternion(attribute) else parts[""]
    n_frames = len(next(iter(parts.values())))
    whole = {name: np.tile(values, (n_frames, 1)) for name, values in codec.split(first[None])._asdict().items()}
    whole.update(parts)
    whole["turns"] = normalize(whole["turns"])
    return codec.join(Parts(**whole), first[None], np.zeros(n_frames, dtype=np.intp))


def _matrix_codec(attribute: Usd.Attribute, numbers: Array) -> Codec | None:
    return codec_of("transform", numbers) if attribute.GetTypeName() == Sdf.ValueTypeNames.Matrix4d else None


def _is_quaternion(attribute: Usd.Attribute) -> bool:
    return UsdGeom.XformOp(attribute).GetOpType() == UsdGeom.XformOp.TypeOrient


def unpacked_ops(prim: Usd.Prim, columns: Mapping[str, Array]) -> dict[str, tuple[Channel, Array]]:
    """Find the ops that are packed with a SkelAnimation.

    Parameters
    ----------
    prim : Usd.Prim
        The SkelAnimation.
    columns : mapping of str to array-like, shape=[F, C]
        What is unpacked beside the joints.

    Returns
    -------
    found : dict of str to (Channel, array-like of shape [F, C])
        What the file has of each, and its numbers at all frames, by path; ops that a stronger layer samples, or that
        are gone, are left out.

    Raises
    ------
    ToolError
        If what is packed is of no such op.
    """
    by_path: dict[str, dict[str, Array]] = {}
    for name, values in columns.items():
        path, _, part = name.partition(" ")
        by_path.setdefault(path, {})[part] = values
    found = {}
    for text, parts in by_path.items():
        attribute = _attribute(prim, text)
        if attribute is None:
            continue
        channel = read_op(attribute)
        try:
            found[str(attribute.GetPath())] = channel, from_parts(attribute, parts, channel.default[0])
        except (KeyError, ValueError) as error:
            raise ToolError(f"{prim.GetPath()}: {PACKED} does not fit {attribute.GetPath()}: {error}.") from error
    return found


def _attribute(prim: Usd.Prim, text: str) -> Usd.Attribute | None:
    """Return the op that is named as seen from a SkelAnimation; None if its samples are not packed any more."""
    path, _, op = text.partition(":")
    relative = Sdf.Path(path) if Sdf.Path.IsValidPathString(path) else Sdf.Path()
    above = relative.MakeAbsolutePath(prim.GetPath()) if relative and not relative.IsAbsolutePath() else Sdf.Path()
    if not above.IsPrimPath() or not Sdf.Path.IsValidNamespacedIdentifier(f"{_PREFIX}{op}"):
        raise ToolError(f"{prim.GetPath()}: {PACKED} holds {text!r}, which is no transform op; pack the source again.")
    attribute = prim.GetStage().GetAttributeAtPath(above.AppendProperty(f"{_PREFIX}{op}"))
    if not attribute:
        return None
    sampled = (spec.layer for spec in attribute.GetPropertyStack() if spec.layer.GetNumTimeSamplesForPath(spec.path))
    return attribute if next(sampled, None) == packed_layer(prim) else None
