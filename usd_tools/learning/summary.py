"""What `learn` says of its work: a table on stdout, and plain values for the report."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from geomstats_anim.learned_metric import Score
from usd_tools.console.errors import Messages
from usd_tools.console.tables import show
from usd_tools.console.text import counted
from usd_tools.learning.files import Skipped
from usd_tools.learning.train import Lesson
from usd_tools.metrics.attributes import summary
from usd_tools.metrics.explain import EXPLANATION, HEADER, joint_meanings, table_rows


def tell(lesson: Lesson, verbose: bool, messages: Messages) -> None:
    """Say what was learned, and what it is worth where it was not learned."""
    takes, metric = lesson.takes, lesson.metric
    n_frames = sum(take.n_frames for take in takes)
    n_keys = sum(metric.provenance["keys"])
    where = str(takes[0]) if len(takes) == 1 else f"{len(takes)} animations, {takes[0]} to {takes[-1]}"
    n_stretches = sum(len(take.stretches) for take in takes)
    cut = f", in {n_stretches} stretches between value blocks and steps" if n_stretches > len(takes) else ""
    print(f"{where}: {n_keys} of {n_frames} samples kept as keys{cut}, {counted(len(metric.joints), 'joint')}")
    print(f"  {summary(metric)}")
    weighted = " without weights" if "weights" in metric.provenance else ""
    is_spline = metric.scheme == "geodesic-spline"
    show(
        f"Q_{metric.quality}{weighted}, lower is better",
        [_row(score, is_spline) for score in lesson.scores],
        ("", "frames", "learned", "slerp", *(("plain spline",) if is_spline else ()), "gain", "verdict"),
    )
    print(conclusion(lesson))
    if lesson.slerped:
        slerped = counted(lesson.slerped, "segment")
        messages.warn(f"{where}: slerp stands for {slerped} of single joints whose geodesic was not found.")
    if verbose:
        show("What the metric means", table_rows(joint_meanings(metric)), HEADER)
        print(EXPLANATION)


def _row(score: Score, is_spline: bool) -> tuple[str, ...]:
    sample = "in-sample" if score.in_sample else "out-of-sample"
    return (
        score.what,
        sample,
        f"{score.learned:.5g}",
        f"{score.slerp:.5g}",
        *((f"{score.plain:.5g}",) if is_spline else ()),
        f"{100.0 * score.gain:+z.1f} %",
        score.verdict,
    )


def conclusion(lesson: Lesson) -> str:
    """Say in a sentence or two what the metric is good for."""
    one = "this clip" if len(lesson.takes) == 1 else "these clips"
    plain = "the plain spline" if lesson.metric.scheme == "geodesic-spline" else "slerp"
    kept = "it is kept" if plain != "slerp" else "slerp's own metric (the identity) is kept"
    unseen = lesson.cross_validated
    if unseen is not None:
        if lesson.is_plain:
            return (
                f"A tie with {plain}: cross-validation found nothing that is sure to predict unseen frames better, so "
                f"{kept}."
            )
        tie = ", which is a tie" if unseen.ties else ""
        loses = " It loses in the rows that say so: do not rely on it there." if lesson.loses else ""
        return f"Cross-validated: predicts blocks of frames left out {unseen.beside_rival}{tie}.{loses}"
    if lesson.is_plain:
        return f"A tie with {plain}: no metric rebuilds {one} better, so {kept}."
    if lesson.loses:
        rivals = " and ".join(sorted({score.rival for score in lesson.scores if not score.in_sample and score.loses}))
        return (
            f"This metric belongs to {one}: it was fitted to rebuild these frames, and loses to {rivals} on frames "
            "that it has not seen. For in-betweening unseen frames use --purpose predict."
        )
    if lesson.scores[0].ties:
        return f"A tie with {lesson.scores[0].rival}: no metric rebuilds {one} noticeably better."
    return f"This metric was fitted to rebuild {one}; for in-betweening unseen frames use --purpose predict."


def described(lesson: Lesson) -> dict[str, Any]:
    """Tell what was learned, as plain values.

    Returns
    -------
    described : dict
        summary; scheme; quality: loc, rot or hyb; animations: file, sha256, prim, frames, stretches (value blocks and
        steps cut); scores: what, in_sample, score, slerp_score, plain_score (the scheme's without learning), gain
        (share of the better of these two), verdict; conclusion;
        joints: joint, alpha, beta, axes (rotation vector or null), invariance, tension,
        translation_tension, and in degrees, null for a
        joint that does not turn, error, slerp_error, gain (in-sample); slerped_segments; provenance: what is stored
        with the metric.
    """
    metric = lesson.metric
    parameters, errors = metric.parameters, {error.joint: error for error in lesson.joints}
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
    return {
        "summary": summary(metric),
        "scheme": metric.scheme,
        "quality": metric.quality,
        "animations": [
            {
                "file": take.file,
                "sha256": take.sha256,
                "prim": take.prim,
                "frames": take.n_frames,
                "stretches": len(take.stretches),
            }
            for take in lesson.takes
        ],
        "scores": [
            {
                "what": score.what,
                "in_sample": score.in_sample,
                "score": score.learned,
                "slerp_score": score.slerp,
                "plain_score": score.plain,
                "gain": score.gain,
                "verdict": score.verdict,
            }
            for score in lesson.scores
        ],
        "conclusion": conclusion(lesson),
        "joints": joints,
        "slerped_segments": lesson.slerped,
        "provenance": dict(metric.provenance),
    }


def described_skipped(skipped: list[Skipped]) -> list[dict[str, str]]:
    """Tell what was not learned from: file, reason."""
    return [asdict(one) for one in skipped]
