"""From a stream back to motion."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from itertools import accumulate

import numpy as np

from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.codec import entropy
from geomstats_anim.codec.chart import references, to_rotations
from geomstats_anim.codec.lattice import Layout, new_lattice, to_values
from geomstats_anim.codec.stream import Header, Segment, StreamError, read_stream
from geomstats_anim.rotations import Array


def unpack(stream: bytes, skeleton: Skeleton, frames: slice | None = None) -> Animation:
    """Return the animation that a stream holds.

    Parameters
    ----------
    stream : bytes
        What `pack` returned.
    skeleton : Skeleton
        What it was packed for.
    frames : slice
        Frames to return, without a step; only the segments that hold them are decoded.
        Optional, default: None, all.

    Returns
    -------
    animation : Animation
        Times bit for bit; rotations, translations and scales within the tolerance of `pack`.

    Raises
    ------
    StreamError
        If the stream is damaged, of another version, or of another skeleton.
    """
    header, values, turns, taken = _decode(stream, skeleton, frames)
    n_joints = skeleton.n_joints
    rotations = np.concatenate(
        [
            to_rotations(references(skeleton.rest_rotations, each), part[:, :n_joints])
            for each, part in zip(turns, values, strict=True)
        ]
    )
    joined = np.concatenate(values)
    at = n_joints
    if header.has_translations:
        translations = skeleton.rest_translations + joined[:, at : at + n_joints]
        at += n_joints
    else:
        translations = np.broadcast_to(skeleton.rest_translations, (*rotations.shape[:2], 3))
    scales = 1.0 + joined[:, at : at + n_joints] if header.has_scales else None
    whole = Animation(skeleton, header.times[taken], rotations, translations, scales)
    return whole if frames is None else whole.at_frames(_within(frames, taken, len(header.times)))


def unpack_channels(stream: bytes, skeleton: Skeleton) -> dict[str, Array]:
    """Return the channels beside the joints, by name, shape=[F, C]; see `unpack`."""
    header, values, _, _ = _decode(stream, skeleton, None)
    joined = np.concatenate(values)
    at, channels = joined.shape[1] - header.n_others, {}
    for channel in header.channels:
        block = joined[:, at : at + channel.n_groups].reshape(len(joined), -1)
        channels[channel.name] = block[:, : channel.n_columns]
        at += channel.n_groups
    return channels


def _decode(
    stream: bytes, skeleton: Skeleton, frames: slice | None
) -> tuple[Header, list[Array], list[np.ndarray], slice]:
    """Return the header, values and references of the segments that hold some frames, and all frames of these."""
    header, segments = read_stream(stream, skeleton)
    layout = header.layout(skeleton)
    bounds = [*accumulate((segment.n_frames for segment in segments), initial=0)]
    first, last = 0, len(segments)
    if frames is not None:
        start, stop, _ = frames.indices(len(header.times))
        first = bisect_right(bounds, start) - 1
        last = max(bisect_left(bounds, stop), first + 1)
    chosen = segments[first:last]
    values = [decode_segment(segment, layout) for segment in chosen]
    if header.is_backwards:
        values = [part[::-1] for part in values]
    return header, values, [segment.turns for segment in chosen], slice(bounds[first], bounds[last])


def decode_segment(segment: Segment, layout: Layout) -> Array:
    """Return the samples of every channel of a segment as they are stored, shape=[F, G, 3]."""
    lattice = new_lattice(layout, segment.steps, 1 if segment.is_still else segment.n_frames, with_basis=False)
    entropy.decode(segment.payload, lattice)
    values = to_values(lattice)
    if not np.isfinite(values).all():
        raise StreamError("The stream is damaged: it holds numbers that are not finite.")
    return np.repeat(values, segment.n_frames, axis=0) if segment.is_still else values


def _within(frames: slice, taken: slice, n_frames: int) -> slice:
    start, stop, _ = frames.indices(n_frames)
    return slice(start - taken.start, stop - taken.start)
