"""Print the result of `inspect` as tables."""

from __future__ import annotations

from typing import Any

from usd_tools.console.tables import show
from usd_tools.console.text import counted, say
from usd_tools.inspection.result import InspectResult
from usd_tools.metrics import explain as metric_meaning
from usd_tools.metrics.explain import JointMeaning, describe_scores
from usd_tools.skel.fault_words import HEADER, count_kinds, fault_rows
from usd_tools.skel.rotation_checks import WIDE_DEGREES

_FAULTS = 10
"""Rows of faults that are printed; JSON has all."""


def print_summary(result: InspectResult) -> None:
    """Print a table for the stage, each skeleton, each animation, and each stored metric."""
    described = result.as_dict()
    show(described["file"], _stage_rows(described))
    for skeleton in described["skeletons"]:
        show(
            f"Skeleton {skeleton['prim']}",
            _skeleton_rows(skeleton),
        )
    for animation in described["animations"]:
        show(f"Animation {animation['prim']}", _animation_rows(animation))
        _print_faults(animation)
        metric = animation.get("metric")
        if metric is not None and metric["error"] is None:
            _print_metric(animation["prim"], metric)
    if not described["animations"]:
        say("No skeletal animation.")


def _print_faults(animation: dict[str, Any]) -> None:
    rows = fault_rows(animation.get("faults", ()))
    if not rows:
        return
    show(f"Faults of {animation['prim']}", rows[:_FAULTS], HEADER)
    more = f"{len(rows) - _FAULTS} more are in --json; " if len(rows) > _FAULTS else ""
    say(f"{more}usd_tools.repair rebuilds them.")


def _print_metric(prim: str, metric: dict[str, Any]) -> None:
    fields = JointMeaning.__dataclass_fields__
    meanings = [JointMeaning(**{name: one[name] for name in fields}) for one in metric["by_joint"]]
    rows = metric_meaning.table_rows(meanings)
    show(f"What the metric of {prim} means", rows, metric_meaning.HEADER)
    say(metric_meaning.EXPLANATION)
    for sentence in describe_scores(metric["provenance"]):
        say(sentence)


def _skeleton_rows(skeleton: dict[str, Any]) -> list[tuple[str, str]]:
    rows = [("joints", str(skeleton["joints"])), ("driven by", skeleton["animation"] or "nothing")]
    if skeleton["size"] is not None:
        rows.append(("size at rest", f"{skeleton['size']:.3g} metres"))
    if skeleton["joints_off_bind_pose"]:
        rows.append(("rest pose", f"{counted(skeleton['joints_off_bind_pose'], 'joint')} away from the bind pose"))
    return rows


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
    if animation["packed_bytes"] is not None:
        rows.append(
            ("packed", f"{animation['packed_bytes']} bytes; usd_tools.unpack restores samples for other programs")
        )
    if animation["stepped_pairs"]:
        rows.append(("stepped pairs", str(animation["stepped_pairs"])))
    step = animation["largest_step"]
    if step is not None:
        where = f"joint {animation['largest_step_joint']}, time code {step['start']:g} to {step['end']:g}"
        rows.append(("largest step", f"{step['degrees']:.1f} degrees: {where}"))
        rows.append((f"steps over {WIDE_DEGREES:g} degrees", str(len(animation["wide_steps"]))))
        rows.append(("sign flips", str(animation["sign_flips"])))
        rows.append(("quaternions not of length 1", str(animation["not_unit_quaternions"])))
    loop = animation["loop"]
    if loop is not None:
        how = "the last pose is the first" if loop["closed"] else "the first pose comes one sample later"
        rows.append(("loop", f"{how}; joint {loop['joint_name']} misses by {loop['misses_degrees']:.2g} degrees"))
    rows.append(("faults", count_kinds(animation["faults"]) or "none"))
    metric = animation["metric"]
    rows.append(("stored metric", "none" if metric is None else metric["error"] or metric["summary"]))
    return rows
