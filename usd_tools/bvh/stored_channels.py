"""The channels that a BVH file had, kept with the Skeleton that was made from it, so that it comes back with them."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd, Vt

from usd_tools.bvh.hierarchy import CHANNELS
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.joint_names import read_names

ATTRIBUTE = "geomstatsAnim:bvhChannels"
"""Custom string[] of a Skeleton: of each joint, the names of its channels in their order."""


def store_channels(skeleton: Usd.Prim, channels: Sequence[Sequence[str]]) -> None:
    """Write the channels of the joints of a Skeleton."""
    attribute = skeleton.CreateAttribute(ATTRIBUTE, Sdf.ValueTypeNames.StringArray, custom=True)
    attribute.Set(Vt.StringArray([" ".join(names) for names in channels]))


def read_channels(clip: SkelClip) -> list[tuple[str, ...]] | None:
    """Read the channels of the joints of a clip's skeleton, in its order; None where nothing usable is stored."""
    if not clip.source.rig:
        return None
    prim = clip.source.rig[0]
    stored, joints = prim.GetAttribute(ATTRIBUTE).Get(), read_names(prim, "joints")
    if not isinstance(stored, Vt.StringArray) or len(stored) != len(joints):
        return None
    channels = {joint: tuple(text.split()) for joint, text in zip(joints, stored, strict=True)}
    if any(set(names) - set(CHANNELS) or len(set(names)) < len(names) for names in channels.values()):
        return None
    return [channels.get(joint, ()) for joint in clip.skeleton.joints]
