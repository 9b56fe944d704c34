"""Describe the work of `learn`: a table, a conclusion, and plain values."""

from __future__ import annotations

import shlex
from typing import Any

from geomstats_anim.names import DEFAULT_SCHEME
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say, say_command, short_names
from usd_tools.learning.result import LearnResult, LibraryReport, MetricReport
from usd_tools.learning.train import AssessedMetric
from usd_tools.metrics.attributes import summary
from usd_tools.metrics.explain import EXPLANATION, HEADER, joint_meanings, table_rows


def print_summary(result: LearnResult, verbose: bool) -> None:
    """Print a table for each metric, and a line on what was written."""
    for report in result.metrics:
        _print_metric(report, verbose)
    if result.library is not None:
        _print_library(result.library)
    if result.path is None:
        return
    if result.path.suffix == ".json":
        say(f"Wrote {result.path}. Use it with:")
        say_command(f"python -m usd_tools.upsample IN -o OUT --factor 4 --metric {shlex.quote(str(result.path))}")
    elif result.library is not None:
        say(f"Wrote {result.path}. Use it with:")
        say_command(f"python -m usd_tools.upsample IN -o OUT --factor 4 --library {shlex.quote(str(result.path))}")
    else:
        say(f"Wrote {result.path}: the metric, with every sample unchanged. usd_tools.upsample uses the metric.")


def _print_library(library: LibraryReport) -> None:
    low, high = library.gaps[0], library.gaps[-1]
    say(
        f"{_named(library.clips)}: {library.frames} frames; in-betweens between keys {low:.2g} to {high:.2g} seconds "
        f"apart, {library.bytes / 1e6:.1f} MB"
    )
    joints = [joint for part in library.parts for joint in part["joints"]]
    names = short_names(joints)
    parts = (f"{part['part']} from {names[part['joints'][0]]}" for part in library.parts if part["joints"])
    say(f"  parts of the body: {', '.join(parts)}")
    say(
        "It helps for motions like those in these clips. Of every clip that uses it, upsample hides every second "
        "sample and keeps of the prediction what helps there."
    )


def _print_metric(report: MetricReport, verbose: bool) -> None:
    n_frames = sum(animation["frames"] for animation in report.animations)
    n_stretches = sum(animation["stretches"] for animation in report.animations)
    n_keys = sum(report.provenance["keys"])
    cut = (
        f", in {n_stretches} stretches between value blocks, steps and cuts" if n_stretches > len(report.clips) else ""
    )
    joints = counted(len(report.joints), "joint")
    say(f"{_named(report.clips)}: {n_keys} of {n_frames} samples kept as keys{cut}, {joints}")
    say(f"  {report.summary}")
    weighted = " without weights" if "weights" in report.provenance else ""
    show(
        f"Q_{report.quality}{weighted}, lower is better",
        [_row(score) for score in report.scores],
        ("", "frames", "learned", "plain spline", "slerp", "gain", "verdict"),
    )
    say(report.conclusion)
    if report.skating:
        say(_skating(report.skating))
    if verbose:
        show("What the metric means", table_rows(joint_meanings(report.metric)), HEADER)
        say(EXPLANATION)


def _skating(skating: dict[str, dict[str, float]]) -> str:
    """Return how planted points skate and float, in words."""
    names = {"learned": "learned", "plain": "plain spline", "slerp": "slerp"}
    skates = ", ".join(f"{names[name]} {found['skate_cm_per_second']:.1f}" for name, found in skating.items())
    floats = ", ".join(f"{found['floating_cm']:.2f}" for found in skating.values())
    return f"Points on the ground skate, in cm per second: {skates}; they float or sink by {floats} cm."


def _named(clips: tuple[str, ...]) -> str:
    return clips[0] if len(clips) == 1 else f"{len(clips)} animations, {clips[0]} to {clips[-1]}"


def slerped_sentence(assessed: AssessedMetric) -> str | None:
    """Return a warning of segments that are slerped; None where there are none."""
    if not assessed.slerped:
        return None
    where, slerped = _named(tuple(map(str, assessed.takes))), counted(assessed.slerped, "segment")
    return f"{where}: no geodesic was found for {slerped} of single joints; using slerp there."


def _row(score: dict[str, Any]) -> tuple[str, ...]:
    sample = "in-sample" if score["in_sample"] else "out-of-sample"
    return (
        score["what"],
        sample,
        f"{score['score']:.5g}",
        f"{score['plain_score']:.5g}",
        f"{score['slerp_score']:.5g}",
        f"{100.0 * score['gain']:+z.1f} %",
        score["verdict"],
    )


def conclusion(assessed: AssessedMetric) -> str:
    """Return a sentence or two on what the metric is good for, beside what `upsample` does without it."""
    own = _own_conclusion(assessed)
    if assessed.metric.scheme == DEFAULT_SCHEME or not assessed.scores[0].loses:
        return own
    return f"{own} Without a metric, upsample uses the plain spline, which is better: use --scheme {DEFAULT_SCHEME}."


def _own_conclusion(assessed: AssessedMetric) -> str:
    one = "this clip" if len(assessed.takes) == 1 else "these clips"
    plain = "the plain spline" if assessed.metric.scheme == "geodesic-spline" else "slerp"
    kept = "it is kept" if plain != "slerp" else "slerp's own metric (the identity) is kept"
    unseen = assessed.cross_validated
    if unseen is not None:
        if assessed.is_plain:
            return (
                f"A tie with {plain}: cross-validation found no metric that reliably predicts unseen frames better, "
                f"so {kept}."
            )
        tie = ", a tie" if unseen.ties else ""
        loses = " It loses where the table says so; do not rely on it there." if assessed.loses else ""
        return f"Cross-validated: it predicts left-out blocks of frames {unseen.beside_rival}{tie}.{loses}"
    if assessed.is_plain:
        return f"A tie with {plain}: no metric rebuilds {one} better, so {kept}."
    if assessed.loses:
        rivals = " and ".join(sorted({score.rival for score in assessed.scores if not score.in_sample and score.loses}))
        return (
            f"This metric was fitted to rebuild {one}, and loses to {rivals} on unseen frames; to in-between those, "
            "use --purpose predict."
        )
    if assessed.scores[0].ties:
        return f"A tie with {assessed.scores[0].rival}: no metric rebuilds {one} noticeably better."
    return f"This metric was fitted to rebuild {one}; to in-between unseen frames, use --purpose predict."


def describe(assessed: AssessedMetric) -> MetricReport:
    """Return what was learned, as plain values."""
    metric = assessed.metric
    return MetricReport(
        metric=metric,
        clips=tuple(map(str, assessed.takes)),
        summary=summary(metric),
        scheme=metric.scheme,
        quality=metric.quality,
        animations=tuple(
            {
                "file": take.file,
                "sha256": take.sha256,
                "prim": take.prim,
                "frames": take.n_frames,
                "stretches": len(take.stretches),
            }
            for take in assessed.takes
        ),
        scores=tuple(
            {
                "what": score.what,
                "in_sample": score.in_sample,
                "score": score.learned,
                "slerp_score": score.slerp,
                "plain_score": score.plain,
                "gain": score.gain,
                "verdict": score.verdict,
            }
            for score in assessed.scores
        ),
        conclusion=conclusion(assessed),
        joints=_joints(assessed),
        slerped_segments=assessed.slerped,
        provenance=dict(metric.provenance),
        skating={
            name: {"skate_cm_per_second": found.skate, "floating_cm": found.floating}
            for name, found in assessed.skating.items()
        },
    )


def _joints(assessed: AssessedMetric) -> tuple[dict[str, Any], ...]:
    metric = assessed.metric
    parameters, errors = metric.parameters, {error.joint: error for error in assessed.joints}
    joints = []
    for i, joint in enumerate(metric.joints):
        error = errors.get(joint)
        joints.append(
            {
                "joint": joint,
                "alpha": float(parameters.alpha[i]),
                "beta": float(parameters.beta[i]),
                "axes": None if parameters.axes is None else parameters.axes[i].tolist(),
                "invariance": parameters.invariance[i],
                "tension": float(metric.tension[i]),
                "translation_tension": float(metric.translation_tension[i]),
                "error": None if error is None else error.learned,
                "slerp_error": None if error is None else error.slerp,
                "gain": None if error is None else round(error.gain, 4),
            }
        )
    return tuple(joints)
