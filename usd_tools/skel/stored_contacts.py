"""Points that are planted on the ground, stored with a sparse animation: what its samples alone cannot tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, Vt

from usd_tools.console.errors import ToolError

JOINTS = "geomstatsAnim:contactJoints"
"""Custom token[] of a SkelAnimation: joints that are planted on the ground at some time, where they start."""

SPANS = "geomstatsAnim:contacts"
"""Custom int3[]: for each time that one is, its index in the joints, and its first and last sample of the source."""

PLACES = "geomstatsAnim:contactPlaces"
"""Custom float3[]: where it is then, in the space of the Skeleton."""

_TYPES = (
    (JOINTS, Sdf.ValueTypeNames.TokenArray),
    (SPANS, Sdf.ValueTypeNames.Int3Array),
    (PLACES, Sdf.ValueTypeNames.Float3Array),
)


@dataclass(frozen=True, eq=False)
class StoredContacts:
    """Contacts as a file stores them.

    Parameters
    ----------
    joints : tuple of str
    spans : array-like of int, shape=[N, 3]
    places : array-like, shape=[N, 3]
    """

    joints: tuple[str, ...]
    spans: np.ndarray
    places: np.ndarray


def write_contacts(spec: Sdf.PrimSpec, contacts: StoredContacts) -> None:
    """Write contacts on a SkelAnimation."""
    values = (
        Vt.TokenArray(contacts.joints),
        Vt.Vec3iArray.FromNumpy(np.ascontiguousarray(contacts.spans, dtype=np.int32)),
        Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(contacts.places, dtype=np.float32)),
    )
    for (name, type_name), value in zip(_TYPES, values, strict=True):
        _attribute(spec, name, type_name).default = value


def hide_contacts(spec: Sdf.PrimSpec, prim: Usd.Prim) -> None:
    """Block the contacts that weaker layers store on a SkelAnimation."""
    if prim.HasAttribute(SPANS):
        for name, type_name in _TYPES:
            _attribute(spec, name, type_name).default = Sdf.ValueBlock()


def read_contacts(prim: Usd.Prim, n_samples: int) -> StoredContacts | None:
    """Read the contacts that a sparse SkelAnimation stores.

    Parameters
    ----------
    prim : Usd.Prim
    n_samples : int
        Of its source.

    Returns
    -------
    contacts : StoredContacts or None
        None if it stores none.

    Raises
    ------
    ToolError
        If they cannot be used.
    """
    joints, spans, places = (prim.GetAttribute(name).Get() for name, _ in _TYPES)
    if spans is None:
        return None
    fits = (
        isinstance(joints, Vt.TokenArray)
        and isinstance(spans, Vt.Vec3iArray)
        and isinstance(places, Vt.Vec3fArray)
        and len(spans) == len(places)
    )
    rows = np.reshape(np.array(spans, dtype=np.intp), (-1, 3)) if fits else np.zeros((0, 3), dtype=np.intp)
    where = np.reshape(np.array(places, dtype=np.float64), (-1, 3)) if fits else np.zeros((0, 3))
    if not (
        fits
        and (rows >= 0).all()
        and (rows[:, 0] < len(joints)).all()
        and (rows[:, 1] < rows[:, 2]).all()
        and (rows[:, 2] < n_samples).all()
        and np.isfinite(where).all()
    ):
        raise ToolError(
            f"{prim.GetPath()}: {SPANS}, {JOINTS} and {PLACES} do not fit together, or not the samples of the source; "
            "remove them, or repair the file."
        )
    return StoredContacts(tuple(joints), rows, where)


def _attribute(spec: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName) -> Sdf.AttributeSpec:
    attribute = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, type_name)
    attribute.custom = True
    return attribute
