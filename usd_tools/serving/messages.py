"""Messages over a pipe: a header in JSON and arrays of numbers. The Blender extension has a copy of this file.

A message is the mark, the sizes of both parts in bytes, the header, and the arrays as float64, little-endian, one after
the other. Nothing in a message is ever run, and sizes are checked before memory is taken.
"""

import json
import math
import struct
from collections.abc import Mapping
from typing import Any, BinaryIO

import numpy as np

MARK = b"GSA1"
LARGEST_HEADER, LARGEST_BODY = 1 << 25, 1 << 30
"""Bytes."""

_SIZES = struct.Struct("<4sQQ")
_DTYPE = np.dtype("<f8")


def write_message(stream: BinaryIO, header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write a message.

    Parameters
    ----------
    stream : binary file
    header : mapping
        Plain values.
    arrays : mapping of str to array-like
        Numbers, by name.
    """
    bodies = {name: np.ascontiguousarray(array, dtype=_DTYPE) for name, array in arrays.items()}
    shapes = [[name, list(body.shape)] for name, body in bodies.items()]
    text = json.dumps({**header, "arrays": shapes}, allow_nan=False).encode()
    stream.write(_SIZES.pack(MARK, len(text), sum(body.nbytes for body in bodies.values())))
    stream.write(text)
    for body in bodies.values():
        stream.write(body.tobytes())
    stream.flush()


def read_message(stream: BinaryIO) -> tuple[dict[str, Any], dict[str, np.ndarray]] | None:
    """Read a message.

    Parameters
    ----------
    stream : binary file

    Returns
    -------
    message : tuple of dict, or None
        Header and arrays; None where the stream ends.

    Raises
    ------
    ValueError
        If what comes is no message.
    """
    start = stream.read(_SIZES.size)
    if not start:
        return None
    if len(start) < _SIZES.size:
        raise ValueError("The message is cut off.")
    mark, header_size, body_size = _SIZES.unpack(start)
    if mark != MARK:
        raise ValueError("This is no message of geomstats-anim, or of another version of it.")
    if header_size > LARGEST_HEADER or body_size > LARGEST_BODY:
        raise ValueError("The message is too large.")
    text, body = stream.read(header_size), stream.read(body_size)
    if len(text) < header_size or len(body) < body_size:
        raise ValueError("The message is cut off.")
    try:
        header = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError("The header of the message is not JSON.") from error
    if not isinstance(header, dict):
        raise ValueError("The header of the message is no object.")
    return header, _arrays(header.pop("arrays", None), body)


def _arrays(shapes: Any, body: bytes) -> dict[str, np.ndarray]:
    """Cut the second part of a message into arrays."""
    numbers, arrays, start = np.frombuffer(body, dtype=_DTYPE) if len(body) % 8 == 0 else None, {}, 0
    if numbers is None or not isinstance(shapes, list) or not all(map(_is_shape, shapes)):
        raise ValueError("The arrays of the message have no shapes.")
    for name, shape in shapes:
        stop = start + math.prod(shape)
        if stop > len(numbers):
            raise ValueError(f"The array {name} of the message is cut off.")
        arrays[name], start = numbers[start:stop].reshape(shape), stop
    if start != len(numbers):
        raise ValueError("The message has numbers of no array.")
    return arrays


def _is_shape(entry: Any) -> bool:
    if not isinstance(entry, list) or len(entry) != 2 or not isinstance(entry[0], str):
        return False
    shape = entry[1]
    return isinstance(shape, list) and all(type(size) is int and 0 <= size <= LARGEST_BODY for size in shape)
