"""Describe the work of `downsample`: lines and tables, warnings, plain values, and a picture."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim.names import WITH_METRIC
from geomstats_anim.rotations import Array
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say, say_command, short_names
from usd_tools.downsampling.reduce import DownsampledClip
from usd_tools.downsampling.result import DownsampledAnimation, DownsampleResult
from usd_tools.downsampling.thinning import Errors
from usd_tools.downsampling.weights import WEIGHTS
from usd_tools.files.atomic import written_beside
from usd_tools.files.paths import same_file
from usd_tools.metrics.attributes import summary
from usd_tools.skel.sizes import clip_bytes_numpy, clip_bytes_usdc

PICTURES = (".png", ".svg", ".pdf")

_COLUMNS = ("mean deg", "99 % deg", "max deg", "mean cm", "99 % cm", "max cm")

_WORST = 5
"""Joints that are shown unless all are."""

_FAR_OFF_DEGREES = 10.0
"""A rotation further off, with every bone end within its tolerance, is worth a warning."""


def print_summary(result: DownsampleResult, source: Path, verbose: bool) -> None:
    """Print what is left of each animation, how well the rest is rebuilt, what a viewer shows, and what was written."""
    for animation in result.animations:
        _print_animation(animation, verbose)
    if result.path is not None:
        _print_file(result, source)


def _print_animation(animation: DownsampledAnimation, verbose: bool) -> None:
    included = "metric" if animation.scheme in WITH_METRIC else "scheme"
    say(
        f"{animation.prim}: {animation.kept_samples} of {animation.samples} samples kept, "
        f"{counted(len(animation.joints), 'joint') if animation.joints else 'blend shapes'}; "
        f"{animation.bytes_usdc_before} -> {animation.bytes_usdc_after} bytes as usdc, "
        f"{animation.bytes_numpy_before} -> {animation.bytes_numpy_after} as NumPy"
        f"{f', {included} included' if animation.joints else ''}"
    )
    weights = animation.weights
    if weights is not None:
        say(
            f"  blendShapeWeights: {weights['kept_samples']} of {weights['samples']} samples kept by "
            f"--weights-tolerance {weights['tolerance']:g}, largest error {weights['largest_error']:.2g}"
        )
    if not animation.joints:
        return
    say(f"  {animation.metric_summary}")
    show(
        "Errors over all frames",
        [
            ("rebuilt by upsample --times source", *_cells(animation.rebuilt)),
            ("played by a viewer, as slerp", *_cells(animation.played)),
        ],
        ("", *_COLUMNS),
    )
    _print_joints(animation, verbose)
    turned = animation.largest_rotation_error
    if turned["degrees"] > 0.0:
        joint = _short_name(animation, turned["joint"])
        where = f"{turned['degrees']:.3g} degrees, joint {joint} at time code {turned['time_code']:g}"
        say(f"Largest rotation error, rebuilt: {where}.")
    uniform = animation.uniform_slerp
    if uniform["samples"]:
        say(
            f"For the same error ({uniform['criterion']}), slerp needs {uniform['samples']} equally spaced samples: "
            f"{uniform['bytes_usdc']} bytes as usdc, {uniform['bytes_numpy']} as NumPy."
        )


def _print_joints(animation: DownsampledAnimation, verbose: bool) -> None:
    worst = sorted(animation.joints, key=lambda joint: -joint["centimetres"]["largest"])
    shown = worst if verbose else [joint for joint in worst[:_WORST] if joint["centimetres"]["largest"] > 0.0]
    if shown:
        names = short_names([joint["joint"] for joint in animation.joints])
        title = f"Worst {len(shown)} joints" if len(shown) > 1 else "Worst joint"
        show(
            f"{'All joints' if verbose else title}, rebuilt",
            [(names[joint["joint"]], *_cells(joint)) for joint in shown],
            ("joint", *_COLUMNS),
        )


def twist_sentence(animation: DownsampledAnimation, tolerance: float) -> str | None:
    """Return a warning if a rotation is far off though every bone end is within the tolerance, in centimetres."""
    turned = animation.largest_rotation_error
    if turned["degrees"] <= _FAR_OFF_DEGREES:
        return None
    joint, code = _short_name(animation, turned["joint"]), turned["time_code"]
    return (
        f"{animation.prim}: bone ends are within {tolerance:g} cm, but joint {joint} is off by {turned['degrees']:.3g} "
        f"degrees at time code {code:g}, since twists barely move bone ends; use --measure shell, or --keep {code:g}."
    )


def _short_name(animation: DownsampledAnimation, joint: str) -> str:
    return short_names([each["joint"] for each in animation.joints])[joint]


def _cells(errors: dict[str, Any]) -> list[str]:
    words = ("mean", "percentile_99", "largest")
    return [f"{errors[unit][word]:.3f}" for unit in ("degrees", "centimetres") for word in words]


def _print_file(result: DownsampleResult, source: Path) -> None:
    out, before, after = result.path, result.file_bytes_before, result.file_bytes_after
    assert out is not None and before is not None and after is not None
    say(f"Wrote {out} ({before} -> {after} bytes). {result.dependencies}. Restore all samples with:")
    say_command(f"python -m usd_tools.upsample {shlex.quote(str(out))} -o BACK.usda --times source")
    if out.suffix == ".usda" and after > before:
        older = "before" if same_file(out, [source]) else source.name
        say(f"{out} is larger than {older} because it is text; use an --out that ends in .usdc.")


def describe(downsampled: DownsampledClip, weights_tolerance: float) -> DownsampledAnimation:
    """Return what was done to an animation, as plain values."""
    selection, clip, sparse, errors = downsampled.selection, downsampled.clip, downsampled.sparse, downsampled.errors
    metric = downsampled.metric if clip.joints else None
    n_frames = [span.stop - span.start for span in selection.spans]
    uniform = selection.sparse(downsampled.uniform)
    return DownsampledAnimation(
        prim=downsampled.path,
        skeletons=downsampled.skeleton_paths,
        samples=sum(n_frames) if n_frames else len(clip.codes),
        kept_samples=len(downsampled.kept),
        kept_time_codes=tuple(downsampled.kept.tolist()),
        scheme=downsampled.metric.scheme,
        metric_summary="" if metric is None else summary(metric),
        constant=tuple(name for name, channel in sparse.channels.items() if not len(channel.codes)),
        kept_whole=tuple(selection.kept_whole),
        weights=_weights(downsampled, weights_tolerance),
        rebuilt=_statistics(errors),
        played=_statistics(downsampled.played),
        joints=tuple(
            {"joint": joint, "degrees": _summary(degrees), "centimetres": _summary(centimetres)}
            for joint, degrees, centimetres in zip(errors.joints, errors.degrees.T, errors.centimetres.T, strict=True)
            if clip.joints
        ),
        largest_rotation_error=_largest_rotation_error(downsampled),
        bytes_usdc_before=clip_bytes_usdc(clip, None, None),
        bytes_usdc_after=clip_bytes_usdc(sparse, metric, clip.codes),
        bytes_numpy_before=clip_bytes_numpy(clip, None),
        bytes_numpy_after=clip_bytes_numpy(sparse, metric),
        uniform_slerp={
            "criterion": downsampled.criterion,
            "samples": sum(map(len, downsampled.uniform)),
            "bytes_usdc": clip_bytes_usdc(uniform, None, None),
            "bytes_numpy": clip_bytes_numpy(uniform, None),
        },
    )


def _weights(downsampled: DownsampledClip, tolerance: float) -> dict[str, Any] | None:
    kept = downsampled.selection.weights
    if kept is None:
        return None
    return {
        "samples": len(downsampled.clip.channels[WEIGHTS].codes),
        "kept_samples": len(kept.codes),
        "tolerance": tolerance,
        "largest_error": downsampled.weights_error,
    }


def _largest_rotation_error(downsampled: DownsampledClip) -> dict[str, Any]:
    errors = downsampled.errors
    if not downsampled.clip.joints:
        return {"joint": "", "degrees": 0.0, "time_code": float(downsampled.clip.codes[0])}
    frame, joint = np.unravel_index(np.argmax(errors.degrees), errors.degrees.shape)
    return {
        "joint": errors.joints[joint],
        "degrees": float(errors.degrees[frame, joint]),
        "time_code": float(downsampled.clip.codes[frame]),
    }


def _statistics(errors: Errors) -> dict[str, Any]:
    return {
        "degrees": _summary(errors.degrees),
        "centimetres": _summary(errors.centimetres),
        **{f"q_{kind}": errors.quality(kind) for kind in ("loc", "rot", "hyb")},
    }


def _summary(values: Array) -> dict[str, float]:
    if not values.size:
        return {"mean": 0.0, "percentile_99": 0.0, "largest": 0.0}
    return {
        "mean": float(values.mean()),
        "percentile_99": float(np.percentile(values, 99.0)),
        "largest": float(values.max()),
    }


def draw(clips: Sequence[DownsampledClip], path: Path) -> None:
    """Draw the samples kept over the speed of the motion, a panel for each animation; see `report.kept_samples`."""
    from usd_tools.downsampling.plot import draw_kept

    figure = draw_kept([each for each in clips if each.clip.joints])
    with written_beside(path) as beside:
        # without a date, the same input makes the same bytes
        dates = {".png": "Creation Time", ".svg": "Date", ".pdf": "CreationDate"}
        figure.savefig(beside, dpi=160, metadata={dates[path.suffix]: None})
