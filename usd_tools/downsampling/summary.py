"""What `downsample` says of its work: lines and tables on stdout, plain values for the report, and a picture."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.names import WITH_METRIC
from geomstats_anim.rotations import Array
from usd_tools.console.errors import Messages
from usd_tools.console.tables import show
from usd_tools.console.text import counted, short_names
from usd_tools.downsampling.reduce import Reduced
from usd_tools.downsampling.thinning import Errors
from usd_tools.files.atomic import written_beside
from usd_tools.files.paths import same_file
from usd_tools.files.stages import describe_dependencies
from usd_tools.metrics.attributes import summary
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.sizes import clip_bytes_numpy, clip_bytes_usdc

PICTURES = (".png", ".svg", ".pdf")

_COLUMNS = ("mean deg", "99 % deg", "max deg", "mean cm", "99 % cm", "max cm")

_WORST = 5
"""Joints that are shown unless all are."""

_FAR_OFF_DEGREES = 10.0
"""A rotation further off, with every bone end within its tolerance, is worth a warning."""


def tell(clip: SkelClip, values: Mapping[str, Any], verbose: bool) -> None:
    """Say what is left of an animation, how well the rest is rebuilt, and what a viewer shows; see `described`."""
    joints = counted(len(clip.joints), "joint")
    print(
        f"{clip.path}: {values['kept_samples']} of {values['samples']} samples kept, {joints}; "
        f"{values['bytes_usdc_before']} -> {values['bytes_usdc_after']} bytes as usdc, "
        f"{values['bytes_numpy_before']} -> {values['bytes_numpy_after']} as NumPy, "
        f"{'metric' if values['scheme'] in WITH_METRIC else 'scheme'} included"
    )
    print(f"  {values['metric_summary']}")
    show(
        "Errors of all frames",
        [
            ("rebuilt by upsample --times source", *_cells(values["rebuilt"])),
            ("played by a viewer, as slerp", *_cells(values["played"])),
        ],
        ("", *_COLUMNS),
    )
    worst = sorted(values["joints"], key=lambda joint: -joint["centimetres"]["largest"])
    shown = worst if verbose else [joint for joint in worst[:_WORST] if joint["centimetres"]["largest"] > 0.0]
    if shown:
        names = short_names([joint["joint"] for joint in values["joints"]])
        title = f"The {len(shown)} joints that are worst" if len(shown) > 1 else "The joint that is worst"
        show(
            f"{'Errors of the joints' if verbose else title}, rebuilt",
            [(names[joint["joint"]], *_cells(joint)) for joint in shown],
            ("joint", *_COLUMNS),
        )
    turned = values["largest_rotation_error"]
    if turned["degrees"] > 0.0:
        print(f"Largest rotation error, rebuilt: {_turned(turned)}.")
    uniform = values["uniform_slerp"]
    if uniform["samples"]:
        print(
            f"Slerp between equally spaced samples needs {uniform['samples']} of them to be as good "
            f"({uniform['criterion']}): {uniform['bytes_usdc']} bytes as usdc, {uniform['bytes_numpy']} as NumPy."
        )


def warn_of_twists(values: Mapping[str, Any], tolerance: float, messages: Messages) -> None:
    """Warn if a rotation is far off though every bone end is within the tolerance, in centimetres; see `described`."""
    turned = values["largest_rotation_error"]
    if turned["degrees"] > _FAR_OFF_DEGREES:
        messages.warn(
            f"{values['prim']}: every bone end is within {tolerance:g} cm, but a rotation is off by {_turned(turned)}, "
            "for turning about a bone's own axis, or of a short bone, moves its end little; name samples to keep "
            "with --keep, or choose by angles: --rate or --keys with --kind rot."
        )


def _turned(turned: Mapping[str, Any]) -> str:
    return f"{turned['degrees']:.3g} degrees, joint {turned['joint']} at time code {turned['time_code']:g}"


def _cells(errors: dict[str, Any]) -> list[str]:
    words = ("mean", "percentile_99", "largest")
    return [f"{errors[unit][word]:.3f}" for unit in ("degrees", "centimetres") for word in words]


def tell_file(source: Path, size_before: int, out: Path, messages: Messages) -> None:
    """Say what is written, what else it needs, and how to get the rest back."""
    print(
        f"{out} is written: {size_before} -> {out.stat().st_size} bytes. {describe_dependencies(out, messages)}; get "
        f"all samples back with: python -m usd_tools.upsample {shlex.quote(str(out))} -o BACK.usda --times source"
    )
    if out.suffix == ".usda" and out.stat().st_size > size_before:
        before = "it was" if same_file(out, [source]) else source.name
        print(f"{out} is larger than {before}, as text; an --out that ends in .usdc makes it binary.")


def described(reduced: Reduced) -> dict[str, Any]:
    """Tell what was done to an animation, as plain values."""
    thinning, clip, sparse, metric = reduced.thinning, reduced.clip, reduced.sparse, reduced.metric
    n_frames = [span.stop - span.start for span in thinning.spans]
    uniform = thinning.sparse(reduced.uniform)
    frame, turned = np.unravel_index(np.argmax(reduced.errors.degrees), reduced.errors.degrees.shape)
    return {
        "prim": clip.path,
        "skeletons": [str(prim.GetPath()) for prim in clip.source.skeletons],
        "samples": sum(n_frames) if n_frames else len(clip.codes),
        "kept_samples": len(reduced.kept),
        "kept_time_codes": reduced.kept.tolist(),
        "scheme": metric.scheme,
        "metric_summary": _summary_of(metric),
        "constant": [name for name, channel in sparse.channels.items() if not len(channel.codes)],
        "kept_whole": list(thinning.kept_whole),
        "rebuilt": _statistics(reduced.errors),
        "played": _statistics(reduced.played),
        "joints": [
            {"joint": joint, "degrees": _summary(degrees), "centimetres": _summary(centimetres)}
            for joint, degrees, centimetres in zip(
                reduced.errors.joints, reduced.errors.degrees.T, reduced.errors.centimetres.T, strict=True
            )
        ],
        "largest_rotation_error": {
            "joint": reduced.errors.joints[turned],
            "degrees": float(reduced.errors.degrees[frame, turned]),
            "time_code": float(clip.codes[frame]),
        },
        "bytes_usdc_before": clip_bytes_usdc(clip, None, None),
        "bytes_usdc_after": clip_bytes_usdc(sparse, metric, clip.codes),
        "bytes_numpy_before": clip_bytes_numpy(clip, None),
        "bytes_numpy_after": clip_bytes_numpy(sparse, metric),
        "uniform_slerp": {
            "criterion": reduced.criterion,
            "samples": sum(map(len, reduced.uniform)),
            "bytes_usdc": clip_bytes_usdc(uniform, None, None),
            "bytes_numpy": clip_bytes_numpy(uniform, None),
        },
    }


def _summary_of(metric: LearnedMetric) -> str:
    """Tell a metric in one line, and of a scheme that uses none just its name."""
    if metric.scheme in WITH_METRIC:
        return summary(metric)
    return f"{metric.scheme}, {counted(len(metric.joints), 'joint')}"


def _statistics(errors: Errors) -> dict[str, Any]:
    return {
        "degrees": _summary(errors.degrees),
        "centimetres": _summary(errors.centimetres),
        **{f"q_{kind}": errors.quality(kind) for kind in ("loc", "rot", "hyb")},
    }


def _summary(values: Array) -> dict[str, float]:
    return {
        "mean": float(values.mean()),
        "percentile_99": float(np.percentile(values, 99.0)),
        "largest": float(values.max()),
    }


def draw(reduced: Sequence[Reduced], path: Path) -> None:
    """Draw the samples kept over the speed of the motion, a panel for each animation; see `report.kept_samples`."""
    from usd_tools.downsampling.plot import draw_kept

    figure = draw_kept(reduced)
    with written_beside(path) as beside:
        # without a date, the same input makes the same bytes
        dates = {".png": "Creation Time", ".svg": "Date", ".pdf": "CreationDate"}
        figure.savefig(beside, dpi=160, metadata={dates[path.suffix]: None})
