"""Parts of long clips whose arrays stay in a processor's cache, and in memory that the system need not clear anew."""

from __future__ import annotations

from collections.abc import Iterator

BLOCK = 1 << 17
"""Rotations in a block: 4 MiB in double precision."""


def joint_blocks(n_joints: int, n_frames: int) -> Iterator[slice]:
    """Cut joints into blocks that are worked on with all of their frames."""
    size = max(1, BLOCK // max(1, n_frames))
    return (slice(start, min(start + size, n_joints)) for start in range(0, n_joints, size))


def frame_blocks(n_frames: int, n_joints: int) -> Iterator[slice]:
    """Cut frames into blocks that are worked on with all joints; each begins with the last frame of the one before."""
    size = max(1, BLOCK // max(1, n_joints))
    return (slice(start, min(start + size, n_frames - 1) + 1) for start in range(0, max(1, n_frames - 1), size))
