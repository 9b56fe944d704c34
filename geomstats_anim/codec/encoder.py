"""From motion to a stream, with the guarantee: what is decoded is measured before anything is returned."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.codec.chart import charted_pieces
from geomstats_anim.codec.decoder import unpack
from geomstats_anim.codec.packer import ExtraChannel, Packer
from geomstats_anim.codec.search import EFFORTS
from geomstats_anim.codec.stream import Channel, Header, write_stream
from geomstats_anim.markers import Markers, largest_by_marker, spread, world_errors
from geomstats_anim.names import SHELL_RADIUS

_TIGHTER = 8
"""Searches at most, the next with more of the markers that are blended, which no search sees as they are."""

_MAIN, _SMALL = 0.5, 0.05
"""Part of a joint in a blended marker from which on it is searched with: at first, and where that does not do."""

_CLOSE = 0.97
"""Of the tolerance: markers beyond it are searched with in the next attempt."""

_TIGHTEN = 0.995
"""Tolerance of the next attempt over what would just do if errors were in proportion."""

_SMALL_STREAM = 1024
"""Bytes below which both directions of time are tried: the smaller a stream, the more they differ by chance."""

_STILL = 1e-9
"""Metres, or units, that a channel may move and still stand still."""


def pack(
    animation: Animation,
    tolerance: float,
    *,
    shell: float = SHELL_RADIUS,
    markers: Markers | None = None,
    scale_tolerance: float = 1e-3,
    channels: Mapping[str, ExtraChannel] | None = None,
    effort: str = "full",
    segment: float | None = None,
    cuts: Sequence[int] = (),
    progress: Callable[[int, int], None] | None = None,
) -> bytes:
    """Pack an animation into few bytes.

    Parameters
    ----------
    animation : Animation
        Its `world`, if any, counts for the errors, and is not packed.
    tolerance : float
        Metres in the world: no joint, bone end or point of the shell is further from its place at any frame.
    shell : float
        Metres from each joint to the points around it.
        Optional, default: `SHELL_RADIUS`.
    markers : Markers
        More points that the tolerance holds for, such as those of a skin.
        Optional, default: none.
    scale_tolerance : float
        How far scales may be from their own.
        Optional, default: .001.
    channels : mapping of str to ExtraChannel
        Numbers to pack beside the joints.
        Optional, default: none.
    effort : str
        "full", or "fast" for a tenth of the time and larger streams.
        Optional, default: "full".
    segment : float
        Seconds of the pieces that can be decoded alone.
        Optional, default: None, one piece.
    cuts : sequence of int
        Frames at which another piece begins, such as those after a jump of the pose.
        Optional, default: none.
    progress : callable
        Called with the frames that are done, and all.
        Optional, default: nobody is told.

    Returns
    -------
    stream : bytes
        For `unpack`. The same on every machine.

    Raises
    ------
    ValueError
        If the tolerance is not positive, a channel does not fit, there is no frame, or the tolerance cannot be kept.
    """
    channels = dict(channels or {})
    _check(animation, tolerance, scale_tolerance, channels, effort, segment)
    skeleton = animation.skeleton
    moves = np.abs(animation.translations - skeleton.rest_translations).max(initial=0.0) > _STILL
    has_scales = animation.scales is not None and np.abs(animation.scales - 1.0).max(initial=0.0) > _STILL
    header = Header(
        animation.times,
        bool(moves),
        has_scales,
        tuple(Channel(name, np.asarray(each.values).shape[1]) for name, each in channels.items()),
    )
    bounds = _pieces(animation, segment, cuts).tolist()
    pieces = list(zip(bounds[:-1], bounds[1:], strict=True))
    around, more = Markers.of_shell(animation, shell), Markers.none() if markers is None else markers
    task = _Task(animation, tolerance, scale_tolerance, channels, effort, around, more, pieces)
    reverse = header._replace(is_backwards=True)
    known = task.packed_before(header) or task.packed_before(reverse)
    if known is not None:
        if progress is not None:
            progress(animation.n_frames, animation.n_frames)
        return known
    stream, worst = task.search(header, progress)
    if worst > tolerance:
        raise ValueError(
            f"The tolerance of {tolerance:g} m cannot be kept; the nearest is {worst:g} m. Use a larger one."
        )
    if len(stream) < _SMALL_STREAM:
        other, its_worst = task.search(reverse, None)
        if its_worst <= tolerance:
            stream = min(stream, other, key=len)
    return stream


class _Task(NamedTuple):
    """Motion to be packed, and the choices for it."""

    animation: Animation
    tolerance: float
    scale_tolerance: float
    channels: Mapping[str, ExtraChannel]
    effort: str
    shell: Markers
    more: Markers
    pieces: list[tuple[int, int]]

    def packed_before(self, header: Header) -> bytes | None:
        """Return the stream that all pieces were decoded from, None if there is none."""
        packer, segments = self._packer(header, self.shell, self.tolerance), []
        for start, stop in self.pieces:
            segment = packer.packed_before(start, stop)
            if segment is None:
                return None
            segments.append(segment)
        stream = write_stream(self.animation.skeleton, header, segments)
        return stream if self._worst(self._decoded(stream)) <= self.tolerance else None

    def search(self, header: Header, progress: Callable[[int, int], None] | None) -> tuple[bytes, float]:
        """Return a stream and its largest error, beyond the tolerance only if nothing keeps that."""
        more, inner = self.more, self.tolerance
        searched = self.shell.joined(_with_one_joint(more.chosen(spread(more)), _MAIN))
        for _ in range(_TIGHTER):
            packer = self._packer(header, searched, inner)
            segments = [packer.pack(start, stop, progress) for start, stop in self.pieces]
            stream = write_stream(self.animation.skeleton, header, segments)
            decoded = self._decoded(stream)
            worst = self._worst(decoded)
            if worst <= self.tolerance:
                break
            further = more.chosen(largest_by_marker(decoded, self.animation, more) > _CLOSE * self.tolerance)
            searched = searched.joined(_with_one_joint(further.chosen(spread(further)), _SMALL))
            inner *= min(1.0, _TIGHTEN * self.tolerance / worst)
        return stream, worst

    def _packer(self, header: Header, searched: Markers, tolerance: float) -> Packer:
        return Packer(self.animation, header, searched, tolerance, self.scale_tolerance, self.channels, self.effort)

    def _decoded(self, stream: bytes) -> Animation:
        return unpack(stream, self.animation.skeleton)

    def _worst(self, decoded: Animation) -> float:
        return float(world_errors(decoded, self.animation, self.shell.joined(self.more)).max(initial=0.0))


def _with_one_joint(markers: Markers, weight: float) -> Markers:
    """Return a marker for each joint that has a part in one: what is blended is no further off than the furthest."""
    which, part = np.nonzero(markers.weights >= weight)
    return Markers.on_joints(markers.joints[which, part], markers.offsets[which, part])


def _check(
    animation: Animation,
    tolerance: float,
    scale_tolerance: float,
    channels: Mapping[str, ExtraChannel],
    effort: str,
    segment: float | None,
) -> None:
    """Refuse what cannot be packed."""
    if not animation.n_frames:
        raise ValueError("The animation has no frame; there is nothing to pack.")
    if effort not in EFFORTS:
        raise ValueError(f"effort is {effort!r}, but it must be one of {', '.join(EFFORTS)}.")
    sizes = {"tolerance": tolerance, "scale_tolerance": scale_tolerance, "segment": 1.0 if segment is None else segment}
    for name, channel in channels.items():
        sizes[f"The tolerance of channel {name!r}"] = channel.tolerance
        shape = np.shape(channel.values)
        if len(shape) != 2 or shape[0] != animation.n_frames or not shape[1]:
            raise ValueError(f"Channel {name!r} has shape {shape}, but ({animation.n_frames}, any) is needed.")
        if not np.isfinite(channel.values).all():
            raise ValueError(f"Channel {name!r} has a value that is not finite.")
    for name, size in sizes.items():
        if not (np.isfinite(size) and size > 0.0):
            raise ValueError(f"{name} is {size:g}, but it must be a positive number.")


def _pieces(animation: Animation, segment: float | None, cuts: Sequence[int]) -> np.ndarray:
    """Return where the pieces begin, and the number of frames."""
    inner = [int(cut) for cut in cuts]
    if segment is not None:
        number = np.floor((animation.times - animation.times[0]) / segment + 1e-9)
        inner += (1 + np.flatnonzero(np.diff(number))).tolist()
    bounds = np.unique(np.clip([0, *inner, animation.n_frames], 0, animation.n_frames))
    return charted_pieces(animation.skeleton.rest_rotations, animation.rotations, bounds)
