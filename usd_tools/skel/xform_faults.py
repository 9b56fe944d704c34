"""Find the faults of the transforms that move a character as a whole, as those of its joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geomstats_anim.faults import Fault, find_faults
from geomstats_anim.names import GAP
from geomstats_anim.spaces import Points, Space, Turns
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.faults import ClipFault, dense_stretches, find_gaps, length_unit
from usd_tools.skel.xforms import XformOp


def find_op_faults(op: XformOp, clip: SkelClip) -> list[ClipFault]:
    """Find the faults of a transform op that was read with its gaps filled in.

    Parameters
    ----------
    op : XformOp
    clip : SkelClip
        Of the character.

    Returns
    -------
    faults : list of ClipFault
        By time; what a turn and a move have at the same time is one. Sizes are degrees of turns, centimetres of moves.
    """
    channel, rate = op.channel, clip.codes_per_second
    gaps = np.zeros(len(channel.codes), dtype=bool) if op.gaps is None else op.gaps
    found = [(fault, False) for fault in find_gaps(gaps[:, None])]
    taken = gaps.copy()
    for span in dense_stretches(channel, rate) if clip.given_cuts is None else ():
        parts = op.codec.split(channel.values[span, 0])
        for values, space, unit in ((parts.turns, Turns(), 1.0), (parts.path, *_path_space(op, clip))):
            if unit == 0.0 or (values == values[0]).all():
                continue
            times = channel.codes[span] / rate
            for fault in find_faults(values[:, None], times, space, gaps[span, None]):
                place = slice(fault.start + span.start, fault.stop + span.start)
                if fault.kind != GAP and not taken[place].any():
                    taken[place] = True
                    is_turn = isinstance(space, Turns) or _is_angle(op)
                    moved = replace(fault, start=place.start, stop=place.stop, size=fault.size * unit)
                    found.append((moved, is_turn))
    return [_named(op, fault, is_turn) for fault, is_turn in sorted(found, key=lambda each: each[0].start)]


def _path_space(op: XformOp, clip: SkelClip) -> tuple[Space, float]:
    """Return how what a codec interpolates on lines is compared, and what its unit is: radians or metres."""
    if _is_angle(op):
        return Points(float(np.degrees(1.0))), 1.0
    unit = length_unit(clip)
    return Points(unit / clip.world_scale if unit else 1.0), unit


def _is_angle(op: XformOp) -> bool:
    return op.attribute.GetName().startswith("xformOp:rotate")


def _named(op: XformOp, fault: Fault, is_turn: bool) -> ClipFault:
    start, end = op.channel.codes[[fault.start, fault.stop - 1]].tolist()
    return ClipFault(op.attribute.GetName(), str(op.attribute.GetPrimPath()), fault, start, end, is_turn)
