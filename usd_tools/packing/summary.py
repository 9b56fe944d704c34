"""Summaries that `pack` and `unpack` print."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from usd_tools.console.tables import show
from usd_tools.console.text import counted, say, say_command
from usd_tools.files.paths import same_file
from usd_tools.packing.result import PackedAnimation, PackResult, UnpackResult
from usd_tools.skel.sizes import COMPARING


def print_packed(result: PackResult, source: Path) -> None:
    """Print the bytes and errors of each animation, and how to get the samples back."""
    for animation in result.animations:
        _print_animation(animation)
    say(COMPARING)
    out, before, after = result.path, result.file_bytes_before, result.file_bytes_after
    if out is None:
        return
    packed = sum(animation.bytes_packed for animation in result.animations)
    say(
        f"Wrote {out} ({before} -> {after} bytes, of which {packed} are packed motion; the rest is skeletons, names, "
        f"meshes and preview). {result.dependencies}. Viewers show {_preview(result)}. Restore all samples with:"
    )
    say_command(f"python -m usd_tools.unpack {shlex.quote(str(out))} -o BACK.usdc")
    if out.suffix == ".usda" and not same_file(out, [source]):
        say("As text, packed motion takes 5/4 of its bytes; use an --out that ends in .usdc for fewer.")


def _preview(result: PackResult) -> str:
    n_keys = result.settings["preview"]
    return f"{n_keys} keys, interpolated" if n_keys else "one pose (--preview K keeps K keys for them)"


def _print_animation(animation: PackedAnimation) -> None:
    what = counted(animation.joints, "joint") if animation.joints else "blend shapes"
    attributes = " and ".join((*animation.packed, *animation.xforms))
    bytes_packed = animation.bytes_packed
    of_usdc, of_numpy = (_ratio(bytes_packed, whole) for whole in (animation.bytes_usdc, animation.bytes_numpy))
    say(
        f"{animation.prim}: {animation.samples} samples, {what}, {attributes}: {bytes_packed} bytes; "
        f"{of_usdc} of {animation.bytes_usdc} as usdc, {of_numpy} of {animation.bytes_numpy} as NumPy"
    )
    errors = animation.errors
    if animation.joints:
        show("Errors over all samples, as read from the file", _rows(errors), ("", "mean", "99 %", "largest"))
        say(f"Jitter of joints: {errors['jitter_centimetres']:.2g} cm per frame squared.")
    for name, word in (("scales", "scales"), ("weights", "blendShapeWeights")):
        if errors[name] is not None:
            say(f"Largest error of {word}: {errors[name]:.2g}.")


def _ratio(part: int, whole: int) -> str:
    return f"{part / whole:.3f}" if whole else "-"


def _rows(errors: dict[str, Any]) -> list[tuple[str, ...]]:
    words = ("mean", "percentile_99", "largest")
    return [
        (name, *(f"{errors[unit][word]:.4f}" for word in words))
        for name, unit in (("points in the world, cm", "centimetres"), ("local rotations, degrees", "degrees"))
    ]


def print_unpacked(result: UnpackResult) -> None:
    """Print what was unpacked."""
    for animation in result.animations:
        first, last = animation.time_codes
        say(
            f"{animation.prim}: {counted(animation.samples, 'sample')} of {counted(animation.joints, 'joint')}, time "
            f"codes {first:g} to {last:g}"
        )
    if result.path is not None:
        sizes = f"{result.file_bytes_before} -> {result.file_bytes_after} bytes"
        say(f"Wrote {result.path} ({sizes}). {result.dependencies}.")
