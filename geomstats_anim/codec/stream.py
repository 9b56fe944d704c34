"""The bytes of a packed animation: header and segments. docs/codec.rst describes them byte by byte."""

from __future__ import annotations

import struct
import zlib
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Skeleton
from geomstats_anim.codec.bytestream import Reader, StreamError, Writer
from geomstats_anim.codec.chart import cube_rotations
from geomstats_anim.codec.lattice import LARGEST_CODE, Layout, Steps, levers
from geomstats_anim.codec.times import read_times, write_times
from geomstats_anim.rotations import Array, to_matrix

__all__ = ["Channel", "Header", "Segment", "StreamError", "fingerprint", "read_stream", "write_stream"]

VERSION = 1
MOST_FRAMES = 2**22
MOST_NUMBERS = 2**23
"""Frames times groups of three channels at most, so that strangers cannot ask for more memory than half a GiB."""

_PREFIX = struct.Struct("<B3sH")
_TRANSLATIONS, _SCALES, _CHANNELS, _BACKWARDS = 1, 2, 4, 8
_GRID = 1e4
"""Cells of the rest pose per metre or unit, by which it is recognised."""

_OFFSET = 0.31830988618379
"""Of that grid, so that no round number is at the edge of a cell."""


class Channel(NamedTuple):
    """A set of numbers beside the joints: its name, and how many at each frame."""

    name: str
    n_columns: int

    @property
    def n_groups(self) -> int:
        """Return the number of groups of three."""
        return -(-self.n_columns // 3)


class Segment(NamedTuple):
    """Frames that are decoded on their own.

    Attributes
    ----------
    n_frames : int
    is_still : bool
        Whether nothing moves, and the integers are those of one frame.
    steps : Steps
    turns : array-like of int, shape=[B]
        Which of `cube_rotations` each reference is away from rest.
    payload : bytes
        The integers, see `entropy`.
    """

    n_frames: int
    is_still: bool
    steps: Steps
    turns: np.ndarray
    payload: bytes


class Header(NamedTuple):
    """Facts that hold for all segments; `is_backwards`: the integers of each are those of its frames in reverse."""

    times: Array
    has_translations: bool
    has_scales: bool
    channels: tuple[Channel, ...]
    is_backwards: bool = False

    @property
    def n_others(self) -> int:
        """Return the number of groups that belong to no joint."""
        return sum(channel.n_groups for channel in self.channels)

    def layout(self, skeleton: Skeleton) -> Layout:
        """Return the groups of each frame."""
        return Layout.of(skeleton, self.has_translations, self.has_scales, self.n_others)


@lru_cache(maxsize=8)
def fingerprint(skeleton: Skeleton) -> int:
    """Return 16 bits by which joints, parents, rest pose and bone ends are recognised, up to .1 mm."""
    rest = np.concatenate(
        [
            skeleton.rest_translations.ravel(),
            to_matrix(skeleton.rest_rotations).ravel(),
            skeleton.bone_ends.ravel(),
            np.log2(levers(skeleton)),
        ]
    )
    cells = np.floor(rest * _GRID + _OFFSET).astype("<i8")
    names = "\n".join(skeleton.joints).encode() + np.asarray(skeleton.parents, dtype="<i8").tobytes()
    return zlib.crc32(cells.tobytes(), zlib.crc32(names)) & 0xFFFF


def write_stream(skeleton: Skeleton, header: Header, segments: list[Segment]) -> bytes:
    """Return a stream."""
    writer = Writer()
    flags = _TRANSLATIONS * header.has_translations + _SCALES * header.has_scales + _CHANNELS * bool(header.channels)
    flags |= _BACKWARDS * header.is_backwards
    writer.number(flags)
    writer.number(len(header.times))
    write_times(writer, header.times)
    if header.channels:
        writer.number(len(header.channels))
        for channel in header.channels:
            writer.block(channel.name.encode())
            writer.number(channel.n_columns)
    writer.number(len(segments))
    for segment in segments[:-1]:
        writer.number(segment.n_frames)
    for segment in segments:
        _write_segment(writer, header, segment, segment is segments[-1])
    body = writer.getvalue()
    check = zlib.crc32(body) & 0xFFFFFF
    return _PREFIX.pack(VERSION, check.to_bytes(3, "little"), fingerprint(skeleton)) + body


def _write_segment(writer: Writer, header: Header, segment: Segment, is_last: bool) -> None:
    writer.number(segment.steps.motion)
    if header.has_scales:
        writer.number(segment.steps.scales)
    at = 0
    for channel in header.channels:
        writer.number(segment.steps.channels[at])
        at += channel.n_groups
    turned = np.flatnonzero(segment.turns)
    writer.number(2 * len(turned) + segment.is_still)
    for joint in turned:
        writer.number(int(joint))
        writer.number(int(segment.turns[joint]))
    if is_last:
        writer.raw(segment.payload)
    else:
        writer.block(segment.payload)


def read_stream(stream: bytes, skeleton: Skeleton | None = None) -> tuple[Header, list[Segment]]:
    """Read header and segments.

    Parameters
    ----------
    stream : bytes
    skeleton : Skeleton
        What it was packed for.
        Optional, default: None, which reads the header only and returns no segments.

    Returns
    -------
    header : Header
    segments : list of Segment

    Raises
    ------
    StreamError
        If the stream is damaged, of another version, or of another skeleton.
    """
    stream = bytes(stream)
    if len(stream) < _PREFIX.size:
        raise StreamError("The stream ends too early; it is damaged or cut off.")
    version, check, mark = _PREFIX.unpack_from(stream)
    if version != VERSION:
        raise StreamError(f"The stream is of version {version}, but this program reads version {VERSION}; update it.")
    body = stream[_PREFIX.size :]
    if zlib.crc32(body) & 0xFFFFFF != int.from_bytes(check, "little"):
        raise StreamError("The stream is damaged: its checksum is wrong.")
    if skeleton is not None and mark != fingerprint(skeleton):
        raise StreamError(
            "The stream was packed for another skeleton: joints, rest pose or bone ends differ; restore the skeleton."
        )
    reader = Reader(body)
    flags = reader.number(_TRANSLATIONS + _SCALES + _CHANNELS + _BACKWARDS)
    n_frames = reader.number(MOST_FRAMES)
    times = read_times(reader, n_frames)
    channels: list[Channel] = []
    for _ in range(reader.number(len(body)) if flags & _CHANNELS else 0):
        name = reader.block().decode("utf-8", "replace")
        channels.append(Channel(name, reader.number(MOST_NUMBERS)))
    has_translations, has_scales = bool(flags & _TRANSLATIONS), bool(flags & _SCALES)
    header = Header(times, has_translations, has_scales, tuple(channels), bool(flags & _BACKWARDS))
    n_joints = 0 if skeleton is None else skeleton.n_joints
    if n_frames * (3 * n_joints + header.n_others) > MOST_NUMBERS:
        raise StreamError("The stream is damaged: it asks for more numbers than a stream may hold.")
    if skeleton is None:
        return header, []
    return header, _read_segments(reader, header, n_joints)


def _read_segments(reader: Reader, header: Header, n_joints: int) -> list[Segment]:
    n_frames = len(header.times)
    n_segments = reader.number(max(n_frames, 1))
    lengths = [reader.number(n_frames) for _ in range(n_segments - 1)]
    lengths.append(n_frames - sum(lengths))
    if not n_segments or min(lengths) < 1:
        raise StreamError("The stream is damaged: its segments do not fill its frames.")
    segments = []
    for i, length in enumerate(lengths):
        motion = reader.number(LARGEST_CODE)
        scales = reader.number(LARGEST_CODE) if header.has_scales else 0
        codes: list[int] = []
        for channel in header.channels:
            codes += [reader.number(LARGEST_CODE)] * channel.n_groups
        turns = np.zeros(n_joints, dtype=np.intp)
        count, is_still = divmod(reader.number(2 * n_joints + 1), 2)
        for _ in range(count):
            joint = reader.number(n_joints - 1)
            turns[joint] = reader.number(len(cube_rotations()) - 1)
        payload = reader.rest() if i == n_segments - 1 else reader.block()
        segments.append(Segment(length, bool(is_still), Steps(motion, scales, tuple(codes)), turns, payload))
    return segments
