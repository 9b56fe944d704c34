"""A library as a file: an .npz of half-precision arrays and a versioned header in JSON, read without running anything.

The arrays are named GAP/reductions, GAP/centres and GAP/weights. Those of all parts of the body stand side by side.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from geomstats_anim.animation import Skeleton
from geomstats_anim.learning.library.context import OFFSETS
from geomstats_anim.learning.library.features import N_FEATURES, Features, Reduction, description_width
from geomstats_anim.learning.library.gap_model import MOST_CENTRES, GapModel
from geomstats_anim.learning.library.motion_library import MotionLibrary
from geomstats_anim.learning.library.parts import BodyParts, body_parts
from geomstats_anim.learning.library.regression import Centres
from geomstats_anim.learning.library.samples import GAPS, n_sines
from geomstats_anim.learning.library.self_check import SHARES
from geomstats_anim.rotations import Array
from geomstats_anim.strict_json import dump_json, parse_json

FORMAT, VERSION = "geomstatsAnim:inBetweens", 3
LARGEST = 1 << 27
"""Bytes of a file, and of what is in it."""

_MOST_JOINTS = 4096


def dump_library(library: MotionLibrary) -> bytes:
    """Write a library, the same bytes for the same library.

    Parameters
    ----------
    library : MotionLibrary

    Returns
    -------
    data : bytes
    """
    skeleton = library.skeleton
    header = {
        "format": FORMAT,
        "version": VERSION,
        "joints": list(skeleton.joints),
        "parents": skeleton.parents.tolist(),
        "restTranslations": skeleton.rest_translations.tolist(),
        "restRotations": skeleton.rest_rotations.tolist(),
        "boneEnds": skeleton.bone_ends.tolist(),
        "vertical": library.vertical.tolist(),
        "usualRotations": library.usual.tolist(),
        "models": [
            {
                "gap": model.gap,
                "units": [reduction.units.tolist() for reduction in model.features.reductions],
                "doubts": model.doubts.tolist(),
            }
            for model in library.models
        ],
        "provenance": dict(library.provenance),
    }
    arrays = {"header": np.frombuffer(dump_json(header).encode(), dtype=np.uint8)}
    for model in library.models:
        reductions = model.features.reductions
        kept = [*(each.components.shape[1] for each in reductions), OFFSETS]
        tables = [np.concatenate([each.mean[:, None], each.components], axis=1) for each in reductions]
        centres = [each[:, :width] for each, width in zip(model.centres.features, kept, strict=True)]
        arrays[f"{model.gap}/reductions"] = _flat(tables)
        arrays[f"{model.gap}/centres"] = np.concatenate(centres, axis=1).astype(np.float16, order="C")
        arrays[f"{model.gap}/weights"] = np.concatenate(model.whitened, axis=1).astype(np.float16, order="C")
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **arrays)
    return file.getvalue()


def _flat(arrays: list[Array]) -> np.ndarray:
    return np.concatenate([each.ravel() for each in arrays]).astype(np.float16)


def load_library(data: bytes) -> MotionLibrary:
    """Read what `dump_library` wrote, or what somebody else made of it.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    library : MotionLibrary

    Raises
    ------
    ValueError
        If it is too large, broken, of another kind or of a newer version.
    """
    if len(data) > LARGEST:
        raise ValueError(f"This library has {len(data)} bytes; at most {LARGEST} are read.")
    members = _members(data)
    header = _header(members)
    try:
        skeleton = Skeleton(
            tuple(header["joints"]),
            header["parents"],
            header["restTranslations"],
            header["restRotations"],
            header["boneEnds"],
        )
        vertical = np.array(header["vertical"], dtype=np.float64)
        if vertical.shape != (3,) or abs(np.linalg.norm(vertical) - 1.0) > 1e-6:
            raise ValueError("its vertical is no unit vector")
        usual = np.array(header["usualRotations"], dtype=np.float64)
        if usual.shape != (skeleton.n_joints, 4) or np.abs(np.linalg.norm(usual, axis=-1) - 1.0).max() > 1e-6:
            raise ValueError("its usual rotations are no unit quaternions, one a joint")
        parts = body_parts(skeleton)
        models = tuple(_models(header["models"], members, parts))
        return MotionLibrary(skeleton, vertical, usual, models, dict(header["provenance"]))
    except KeyError as error:
        raise ValueError(f"This library is broken: it has no {error}.") from None
    except (TypeError, ValueError, OverflowError, np.linalg.LinAlgError) as error:
        raise ValueError(f"This library is broken: {error}.") from None


def _members(data: bytes) -> dict[str, np.ndarray]:
    """Read the arrays of an .npz, without pickle, and no more than are expected."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            found = archive.infolist()
            if len(found) > 1 + 3 * len(GAPS) or sum(each.file_size for each in found) > LARGEST:
                raise ValueError("This library is broken: it holds more than a library does.")
            return {each.filename.removesuffix(".npy"): _array(archive, each) for each in found}
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError, zipfile.LargeZipFile) as error:
        raise ValueError(f"This is no library of in-betweens: {error}.") from None


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> np.ndarray:
    """Read one array of half-precision numbers or bytes, no larger than its file."""
    if member.compress_type != zipfile.ZIP_STORED:
        raise ValueError("This library is broken: it is compressed.")
    with archive.open(member) as file:
        stream = io.BytesIO(file.read(LARGEST + 1))
    try:
        if np.lib.format.read_magic(stream) != (1, 0):
            raise ValueError("an array has another version")
        shape, fortran_order, dtype = np.lib.format.read_array_header_1_0(stream)
        rest = stream.read()
        if fortran_order or dtype not in (np.dtype("<f2"), np.dtype("u1")):
            raise ValueError(f"an array holds {dtype}")
        if len(shape) > 2 or dtype.itemsize * int(np.prod(shape, dtype=object)) != len(rest):
            raise ValueError("an array has another size than it says")
    except Exception as error:  # of whatever a stranger's bytes do to NumPy's parser
        raise ValueError(f"This library is broken: {error}.") from None
    return np.frombuffer(rest, dtype=dtype).reshape(shape)


def _header(members: dict[str, np.ndarray]) -> Mapping[str, Any]:
    if "header" not in members or members["header"].dtype != np.uint8:
        raise ValueError("This is no library of in-betweens: it has no header.")
    try:
        header = parse_json(members["header"].tobytes().decode("utf-8"))
    except UnicodeDecodeError:
        raise ValueError("This library is broken: its header is not UTF-8.") from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise ValueError("This is no library of in-betweens: its header is of another format.")
    if header.get("version") != VERSION:
        raise ValueError(f"This library has version {header.get('version')}, but this program reads {VERSION}.")
    if not isinstance(header.get("joints"), list) or not 0 < len(header["joints"]) <= _MOST_JOINTS:
        raise ValueError(f"This library is broken: it has no joints, or more than {_MOST_JOINTS}.")
    return header


def _models(listed: Any, members: dict[str, np.ndarray], parts: BodyParts) -> Iterator[GapModel]:
    gaps = [model["gap"] for model in listed]
    if gaps != sorted(set(gaps)) or not set(gaps) <= set(GAPS):
        raise ValueError(f"it has models of the gaps {gaps}")
    for model in listed:
        yield _model(int(model["gap"]), model["units"], model["doubts"], members, parts)


def _model(gap: int, numbers: Any, listed: Any, members: dict[str, np.ndarray], parts: BodyParts) -> GapModel:
    widths = [description_width(len(joints)) for joints in parts.joints]
    kept = [min(N_FEATURES, width) for width in widths]
    columns = [n_sines(gap) * 3 * len(joints) for joints in parts.joints]
    reductions, centres, weights = (_half(members, f"{gap}/{name}") for name in ("reductions", "centres", "weights"))
    sizes = [width * (1 + n) for width, n in zip(widths, kept, strict=True)]
    n_centres = len(centres)
    shapes = {
        "reductions": (reductions.shape, (sum(sizes),)),
        "centres": (centres.shape, (n_centres, sum(kept) + OFFSETS)),
        "weights": (weights.shape, (n_centres, sum(columns))),
    }
    for name, (shape, wanted) in shapes.items():
        if shape != wanted:
            raise ValueError(f"{gap}/{name} has shape {shape}, but {wanted} is needed")
    if not 0 < n_centres <= MOST_CENTRES:
        raise ValueError(f"it has {n_centres} centres")
    units = np.array(numbers, dtype=np.float64)
    if units.shape != (len(widths), 3) or not (units[:, [0, 2]] > 0.0).all():
        raise ValueError("its features have no units")
    doubts = np.array(listed, dtype=np.float64)
    if doubts.shape != (len(widths), len(SHARES), 2) or not (doubts >= 0.0).all():
        raise ValueError("its doubts are no table of numbers from 0")
    tables = [
        table.reshape(width, -1)
        for table, width in zip(np.split(reductions, np.cumsum(sizes)[:-1]), widths, strict=True)
    ]
    of_parts = tuple(Reduction(row, table[:, 0], table[:, 1:]) for row, table in zip(units, tables, strict=True))
    features = np.zeros((len(kept) + 1, n_centres, N_FEATURES))
    for own, each in zip(features, _columns(centres, kept), strict=True):
        own[:, : each.shape[1]] = each
    return GapModel(
        gap, n_sines(gap), Features(parts, of_parts), Centres(features), _columns(weights, columns)[:-1], doubts
    )


def _columns(table: Array, widths: Sequence[int]) -> tuple[Array, ...]:
    """Part a table into blocks of columns, the last of which is what is left."""
    return tuple(map(np.ascontiguousarray, np.split(table, np.cumsum(widths), axis=1)))


def _half(members: dict[str, np.ndarray], name: str) -> Array:
    values = members[name].astype(np.float64)
    if members[name].dtype != np.float16 or not np.isfinite(values).all():
        raise ValueError(f"{name} holds what is no number")
    return values
