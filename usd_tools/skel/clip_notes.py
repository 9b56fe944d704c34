"""Sentences about a clip that a user should know."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from usd_tools.console.text import short_names
from usd_tools.skel.channels import VALUE_CLIPS
from usd_tools.skel.find import BINDING, chosen_variants, find_binding
from usd_tools.skel.joint_names import read_names

if TYPE_CHECKING:
    from usd_tools.skel.clip import SkelClip


def missing_note(clip: SkelClip, absent: Sequence[str]) -> str:
    """Return what is done about channels that are not authored."""
    skeletons = clip.source.skeletons
    of = f" of {skeletons[0].GetPath()}" if len(skeletons) > 1 else ""
    done = f"written from the rest pose{of}" if len(clip.missing) == len(absent) else "not known without a skeleton"
    return f"{clip.path} has no {' and no '.join(absent)}, so viewers show the rest pose; {done}."


def binding_notes(clip: SkelClip) -> list[str]:
    """Return notes on a binding that OpenUSD ignores, and on an animation that has no joint of what it drives."""
    joints, skeletons = clip.joints, clip.source.skeletons
    notes = [
        f"{binding.GetPath()} has skel:animationSource {binding.GetRelationship(BINDING).GetTargets()[0]}, but "
        "SkelBindingAPI is not applied, so USD ignores it."
        for binding in map(find_binding, clip.source.ignored)
        if binding
    ]
    own = read_names(skeletons[0], "joints") if skeletons else ()
    if not own or not joints or set(own) & set(joints):
        return notes
    names = short_names([*joints, *own])
    others = ", ".join(names[joint] for joint in own[:3])
    return [
        *notes,
        f"{clip.path} has no joint of {skeletons[0].GetPath()}, which it drives, so nothing moves in viewers; "
        f"{names[joints[0]]} is not one of {others}{'' if len(own) <= 3 else ' and others'}.",
    ]


def variant_notes(clip: SkelClip) -> list[str]:
    """Return notes on the variants that samples written over an animation hide."""
    if not clip.is_animated:
        return []
    return [
        f"{clip.path} is of the variant {variant}; the output overrides its other variants."
        for variant in chosen_variants(clip.source.prim)
    ]


def composition_notes(clip: SkelClip) -> list[str]:
    """Return notes on what samples that are written over an animation hide."""
    return variant_notes(clip) + [
        f"{clip.path}: {name} come from value clips; the samples in the output override them."
        for name, channel in clip.channels.items()
        if channel.source == VALUE_CLIPS
    ]
