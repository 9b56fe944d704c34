"""Show the skeletal animation of a USD file, and warn of what may go wrong.

    python -m usd_tools.inspect walk.usda

With `--json` the same as plain values: one object with the stage's metadata, `skeletons`, `animations` and `warnings`.
Codes are time codes of the stage; a value that does not apply is null.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say, short_names
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import open_stage
from usd_tools.metrics import explain as metric_meaning
from usd_tools.metrics.attributes import read_metric, read_source_codes, summary
from usd_tools.metrics.explain import JointMeaning, describe_scores, joint_meanings
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import AnimationSource, find_animations
from usd_tools.skel.joint_names import read_names
from usd_tools.skel.rotation_checks import (
    WIDE_DEGREES,
    count_not_unit,
    count_sign_flips,
    largest_step,
    rotation_steps,
    wide_steps,
)

PROG = "python -m usd_tools.inspect"


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Show the skeletal animation of a USD file, and warn of what may go wrong.",
    )
    parse.add_argument("input", metavar="IN", type=Path, help="USD file")
    parse.add_argument("--json", action="store_true", help="print JSON instead of tables")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    args = parser(prog).parse_args(argv)
    return run(lambda: inspect(args))


@openusd_errors()
def inspect(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    messages = Messages(print_warning)
    with usd_warnings(messages), reading(args.input):
        stage = open_stage(args.input)
        described = describe(stage, args.input, messages)
    described["warnings"] = messages.warnings
    if args.json:
        print(json.dumps(described, indent=2))
    else:
        _print_tables(described)
    return 0


def describe(stage: Usd.Stage, path: Path, messages: Messages) -> dict[str, Any]:
    """Tell what is on a stage, as plain values.

    Parameters
    ----------
    stage : Usd.Stage
    path : Path
        File that it was opened from.
    messages : Messages
        Told what to beware of.

    Returns
    -------
    described : dict
        file, layers, default_prim, up_axis, meters_per_unit, time_codes_per_second, frames_per_second,
        start_time_code, end_time_code;
        skeletons: prim, joints, animation, instance;
        animations: prim, instances, skeletons, error (then nothing more), joints, still_joints, blend_shapes,
        meters_per_unit (in the world), channels (a name each: samples, value_blocks, held_gaps, from), samples, codes
        and seconds (first and last), samples_per_second, evenly_spaced, samples_of_source (of a sparse animation),
        stepped_pairs, largest_step and wide_steps (joint, start, end, degrees), sign_flips, not_unit_quaternions,
        metric (error, summary, scheme, joints, quality, provenance, by_joint: see `metric_meaning.as_dict`).
    """
    root = stage.GetRootLayer()
    sources = find_animations(stage)
    return {
        "file": path.name,
        "layers": _names_of_layers(stage),
        "default_prim": root.defaultPrim or None,
        "up_axis": str(UsdGeom.GetStageUpAxis(stage)),
        "meters_per_unit": UsdGeom.GetStageMetersPerUnit(stage),
        "time_codes_per_second": stage.GetTimeCodesPerSecond(),
        "frames_per_second": stage.GetFramesPerSecond() if root.HasFramesPerSecond() else None,
        "start_time_code": stage.GetStartTimeCode() if root.HasStartTimeCode() else None,
        "end_time_code": stage.GetEndTimeCode() if root.HasEndTimeCode() else None,
        "skeletons": [
            _describe_skeleton(prim, sources, messages)
            for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
            if prim.IsA(UsdSkel.Skeleton)
        ],
        "animations": [_describe_animation(source, messages) for source in sources],
    }


def _names_of_layers(stage: Usd.Stage) -> list[str]:
    """Name the layers of a stage: its root, then the others by name, for OpenUSD lists them in any order."""
    others = [layer for layer in stage.GetUsedLayers() if layer != stage.GetRootLayer() and not layer.anonymous]
    root = [] if stage.GetRootLayer().anonymous else [stage.GetRootLayer().GetDisplayName()]
    return root + sorted(layer.GetDisplayName() for layer in others)


def _describe_skeleton(prim: Usd.Prim, sources: list[AnimationSource], messages: Messages) -> dict[str, Any]:
    driven_by = next((source.path for source in sources if prim in source.skeletons), None)
    binding = prim.GetRelationship("skel:animationSource")
    if driven_by is None and binding and binding.GetTargets():
        reason = (
            "its target is not an animation on this stage"
            if prim.HasAPI(UsdSkel.BindingAPI)
            else "SkelBindingAPI is not applied, so USD ignores it"
        )
        messages.warn(f"{prim.GetPath()} has skel:animationSource {binding.GetTargets()[0]}, but {reason}.")
    return {
        "prim": str(prim.GetPath()),
        "joints": _count_joints(prim, messages),
        "animation": driven_by,
        "instance": prim.IsInstanceProxy(),
    }


def _count_joints(skeleton: Usd.Prim, messages: Messages) -> int | None:
    try:
        return len(read_names(skeleton, "joints"))
    except ToolError as error:
        messages.warn(str(error))
        return None


def _describe_animation(source: AnimationSource, messages: Messages) -> dict[str, Any]:
    described: dict[str, Any] = {
        "prim": source.path,
        "instances": [str(prim.GetPath()) for prim in source.prims[1:]],
        "skeletons": [str(prim.GetPath()) for prim in source.skeletons],
    }
    try:
        clip = read_clip(source)
    except ToolError as error:
        messages.warn(str(error))
        return {**described, "error": str(error)}
    for note in clip.notes:
        messages.warn(note)
    degrees = rotation_steps(clip)
    largest, wide = largest_step(clip, degrees), wide_steps(clip, degrees)
    for step in wide:
        turn = step.in_words(short_names(clip.joints))
        messages.warn(f"{clip.path}: {turn}; a file cannot store which way a turn beyond 180 degrees went.")
    rotations = clip.channels.get("rotations")
    return {
        **described,
        "error": None,
        "joints": len(clip.joints),
        "still_joints": _count_still(clip),
        "blend_shapes": len(read_names(source.prim, "blendShapes")),
        "meters_per_unit": clip.world_scale,
        "channels": {name: _describe_channel(channel) for name, channel in clip.channels.items()},
        **_describe_times(clip),
        "samples_of_source": _count_source_samples(source, messages),
        "stepped_pairs": int(clip.steps.sum()),
        "largest_step": None if largest is None else asdict(largest),
        "wide_steps": [asdict(step) for step in wide],
        "sign_flips": 0 if rotations is None else count_sign_flips(rotations),
        "not_unit_quaternions": 0 if rotations is None else count_not_unit(rotations),
        "metric": _describe_metric(source, messages),
    }


def _describe_channel(channel: Channel) -> dict[str, Any]:
    return {
        "samples": len(channel.codes),
        "value_blocks": int(channel.blocked.sum()),
        "held_gaps": int(channel.holds.all(axis=-1).sum()),
        "from": channel.source or None,
    }


def _describe_times(clip: SkelClip) -> dict[str, Any]:
    codes = clip.codes
    if not len(codes):
        return dict.fromkeys(("samples", "codes", "seconds", "samples_per_second", "evenly_spaced"))
    gaps = np.diff(codes)[~clip.steps]
    return {
        "samples": len(codes),
        "codes": [float(codes[0]), float(codes[-1])],
        "seconds": [float(code / clip.codes_per_second) for code in codes[[0, -1]]],
        "samples_per_second": clip.samples_per_second(),
        "evenly_spaced": bool(np.allclose(gaps, gaps[0], rtol=1e-4)),
    }


def _count_source_samples(source: AnimationSource, messages: Messages) -> int | None:
    try:
        codes = read_source_codes(source.prim)
    except ToolError as error:
        messages.warn(str(error))
        return None
    return None if codes is None else len(codes)


def _count_still(clip: SkelClip) -> int:
    """Count the joints that never move, bit for bit."""
    still = np.ones(len(clip.joints), dtype=bool)
    for name in ("rotations", "translations", "scales"):
        if name in clip.channels:
            still &= clip.channels[name].holds.all(axis=0)
    return int(still.sum())


def _describe_metric(source: AnimationSource, messages: Messages) -> dict[str, Any] | None:
    try:
        metric = read_metric(source.prim)
    except ToolError as error:
        messages.warn(str(error))
        return {"error": str(error)}
    if metric is None:
        return None
    return {
        "error": None,
        "summary": summary(metric),
        "scheme": metric.scheme,
        "joints": len(metric.joints),
        "quality": metric.quality,
        "provenance": dict(metric.provenance),
        "by_joint": [metric_meaning.as_dict(meaning) for meaning in joint_meanings(metric)],
    }


def _print_tables(described: dict[str, Any]) -> None:
    show(described["file"], _stage_rows(described))
    for skeleton in described["skeletons"]:
        show(
            f"Skeleton {skeleton['prim']}",
            [("joints", str(skeleton["joints"])), ("driven by", skeleton["animation"] or "nothing")],
        )
    for animation in described["animations"]:
        show(f"Animation {animation['prim']}", _animation_rows(animation))
        metric = animation.get("metric")
        if metric is not None and metric["error"] is None:
            _print_metric(animation["prim"], metric)
    if not described["animations"]:
        say("No skeletal animation.")


def _print_metric(prim: str, metric: dict[str, Any]) -> None:
    fields = JointMeaning.__dataclass_fields__
    meanings = [JointMeaning(**{name: one[name] for name in fields}) for one in metric["by_joint"]]
    rows = metric_meaning.table_rows(meanings)
    show(f"What the metric of {prim} means", rows, metric_meaning.HEADER)
    say(metric_meaning.EXPLANATION)
    for sentence in describe_scores(metric["provenance"]):
        say(sentence)


def _stage_rows(described: dict[str, Any]) -> list[tuple[str, str]]:
    start, end = described["start_time_code"], described["end_time_code"]
    frames = described["frames_per_second"]
    return [
        ("layers", ", ".join(described["layers"])),
        ("default prim", described["default_prim"] or "none"),
        ("up axis", described["up_axis"]),
        ("metres per unit", f"{described['meters_per_unit']:g}"),
        ("time codes per second", f"{described['time_codes_per_second']:g}"),
        ("frames per second", "not authored" if frames is None else f"{frames:g}"),
        ("range of the stage", "not authored" if None in (start, end) else f"{start:g} to {end:g}"),
    ]


def _animation_rows(animation: dict[str, Any]) -> list[tuple[str, str]]:
    rows = [("drives", ", ".join(animation["skeletons"]) or "no skeleton")]
    if animation["instances"]:
        rows.append(("also at", ", ".join(animation["instances"])))
    if animation["error"] is not None:
        return [*rows, ("error", animation["error"])]
    rows.append(("joints", f"{animation['joints']}, {animation['still_joints']} never move"))
    if animation["blend_shapes"]:
        rows.append(("blend shapes", str(animation["blend_shapes"])))
    rows.append(("metres per unit", f"{animation['meters_per_unit']:g}"))
    for name, channel in animation["channels"].items():
        samples = counted(channel["samples"], "sample")
        words = [f"{samples} from {channel['from']}" if channel["samples"] else "one value"]
        if channel["held_gaps"]:
            words.append(counted(channel["held_gaps"], "held gap"))
        if channel["value_blocks"]:
            words.append(counted(channel["value_blocks"], "value block"))
        rows.append((name, ", ".join(words)))
    if animation["samples"] is None:
        rows.append(("motion", "none"))
    else:
        (first, last), (start, end) = animation["codes"], animation["seconds"]
        even = "evenly" if animation["evenly_spaced"] else "not evenly"
        alike = len({channel["samples"] for channel in animation["channels"].values() if channel["samples"] > 1}) == 1
        together = "" if alike else ", all attributes together"
        rows += [
            ("time codes", f"{first:g} to {last:g}"),
            ("seconds", f"{start:g} to {end:g}, {end - start:g} long"),
            ("rate", f"{animation['samples_per_second']:g} samples per second, {even} spaced{together}"),
        ]
    n_source = animation["samples_of_source"] or 0
    if any(1 < channel["samples"] < n_source for channel in animation["channels"].values()):
        rows.append(("source had", f"{n_source} samples; usd_tools.upsample --times source restores them"))
    if animation["stepped_pairs"]:
        rows.append(("stepped pairs", str(animation["stepped_pairs"])))
    step = animation["largest_step"]
    if step is not None:
        where = f"joint {step['joint']}, time code {step['start']:g} to {step['end']:g}"
        rows.append(("largest step", f"{step['degrees']:.1f} degrees: {where}"))
        rows.append((f"steps over {WIDE_DEGREES:g} degrees", str(len(animation["wide_steps"]))))
        rows.append(("sign flips", str(animation["sign_flips"])))
        rows.append(("quaternions not of length 1", str(animation["not_unit_quaternions"])))
    metric = animation["metric"]
    rows.append(("stored metric", "none" if metric is None else metric["error"] or metric["summary"]))
    return rows


if __name__ == "__main__":
    sys.exit(main())
