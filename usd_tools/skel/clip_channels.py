"""Read the channels of a SkelAnimation, and refuse those that cannot be computed with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usd_tools.console.errors import ToolError
from usd_tools.console.text import short_names
from usd_tools.skel.channels import JOINT_CHANNELS, Channel, read_channel
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.gaps import turns_of_no_length
from usd_tools.skel.joint_names import read_names


def read_channels(
    source: AnimationSource, joints: Sequence[str], allows_gaps: bool = False
) -> tuple[dict[str, Channel], list[str]]:
    """Read what is authored, see `read_channel`, and say what cannot be read but need not stop the rest."""
    prim, notes = source.prim, []
    read = {name: read_channel(prim, name, len(joints), allows_gaps) for name in JOINT_CHANNELS}
    channels = {name: channel for name, channel in read.items() if channel is not None}
    if not joints and any(channel.is_animated for channel in channels.values()):
        raise ToolError(f"{source.path} has samples, but no joints; author its joints.")
    n_shapes = len(read_names(prim, "blendShapes"))
    try:
        weights = read_channel(prim, "blendShapeWeights", n_shapes, allows_gaps) if n_shapes else None
        if weights is not None:
            channels["blendShapeWeights"] = weights
    except ToolError as error:
        # USD holds weights whose number changes; they cannot be interpolated, but need not keep the joints from it.
        notes.append(f"{str(error).rpartition('; ')[0]}; the weights are left as they are.")
    return channels, notes


def check_rotations(path: str, joints: Sequence[str], channel: Channel | None) -> None:
    """Refuse a quaternion of no length, but of joints that never move: there OpenUSD shows it, without a turn."""
    if channel is None:
        return
    zeros = np.argwhere(turns_of_no_length(channel))
    if len(zeros):
        joint = short_names(joints)[joints[zeros[0][1]]]
        raise ToolError(
            f"{path}: joint {joint} has a rotation that is a quaternion of length 0; usd_tools.repair fills it in."
        )


def check_times(path: str, codes: np.ndarray, rate: float) -> None:
    """Refuse times that cannot be computed with."""
    if not (np.isfinite(rate) and rate > 0.0):
        raise ToolError(f"{path}: its stage has {rate:g} time codes per second; correct timeCodesPerSecond.")
    with np.errstate(all="ignore"):
        seconds = codes / rate
        bad = ~np.isfinite(seconds) | ~(np.diff(seconds, prepend=-np.inf) > 0.0)
    if bad.any():
        raise ToolError(
            f"{path}: time code {codes[bad][0]:g}, at {rate:g} per second, is not later than the sample before; "
            "repair the file."
        )
