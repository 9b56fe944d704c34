"""Compute and draw the figures of mathematics.rst: python docs/make_figures.py. The pictures are kept in git."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from geomstats_anim import (
    Animation,
    LearnedMetric,
    MetricParameters,
    Skeleton,
    compress,
    interpolate,
    learn_metric,
    optimal_keyframes,
    quality,
    uniform_keyframes,
)
from geomstats_anim.contacts import Plants, find_contacts, plant
from geomstats_anim.interpolation.tangents import hermite
from geomstats_anim.markers import joint_matrices
from geomstats_anim.rotations import Array, distance
from usd_tools.example_clips.biped import INDEX, OFFSETS, PARENTS, joint_paths
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.posing import RATE
from usd_tools.figures.style import FAINT, INK, TRUTH, look

_HERE = Path(__file__).resolve().parent

_STYLE = {
    "font.size": 11.0,
    "font.family": "DejaVu Sans",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "svg.hashsalt": "geomstats-anim",
    "svg.fonttype": "path",
}
_PALETTE = ("#7b3fb5", "#d81b60", "#1d9a8a", "#f07f1b")


def clip(name: str) -> Animation:
    """Make one of the example clips."""
    motion = MOTIONS[name]()
    n_frames = len(motion.rotations)
    places = np.tile(OFFSETS, (n_frames, 1, 1))
    places[:, 0] = motion.hips
    still = np.tile([0.0, 0.0, 0.0, 1.0], (len(PARENTS), 1))
    skeleton = Skeleton(tuple(joint_paths()), PARENTS, OFFSETS, still)
    return Animation(skeleton, np.arange(n_frames) / RATE, motion.rotations, places)


def joint_of(animation: Animation, joint: int) -> Animation:
    """Take one joint alone, its parent at rest; the bone is along its bone end, one metre long."""
    bone = animation.skeleton.bone_ends[joint]
    skeleton = Skeleton(["joint"], [-1], np.zeros((1, 3)), [[0, 0, 0, 1]], [bone / np.linalg.norm(bone)])
    rotations = animation.rotations[:, [joint]]
    return Animation(skeleton, animation.times, rotations, np.zeros((animation.n_frames, 1, 3)))


def turning(rotations: Array, times: Array) -> Animation:
    """Make keys of one joint whose bone is its x axis."""
    skeleton = Skeleton(["joint"], [-1], np.zeros((1, 3)), [[0, 0, 0, 1]], [[1.0, 0.0, 0.0]])
    return Animation(skeleton, times, rotations[:, None], np.zeros((len(times), 1, 3)))


def tips(animation: Animation) -> Array:
    """Return the places of the end of the bone, (F, 3)."""
    return Rotation.from_quat(animation.rotations[:, 0]).apply(animation.skeleton.bone_ends[0].copy())


def facing(points: Array, up: float = 0.0) -> Rotation:
    """Look at the middle of some points on the sphere, turned by some degrees."""
    middle = points.mean(axis=0)
    return Rotation.align_vectors([[0, 0, 1], [np.sin(np.radians(up)), 1, 0]], [middle, [0, 0, 1]], [1e6, 1.0])[0]


def draw_sphere(axes: Axes, view: Rotation) -> None:
    """Draw the unit sphere with meridians and parallels, fainter behind."""
    axes.set(xlim=(-1.06, 1.06), ylim=(-1.06, 1.06), aspect="equal")
    axes.set_axis_off()
    axes.add_patch(matplotlib.patches.Circle((0, 0), 1.0, fc="#fbfafd", ec="#c9c8d6", lw=1.2, zorder=0))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circles = [np.stack([np.cos(t) * np.cos(turn), np.sin(t) * np.cos(turn), np.sin(turn)], -1) for t in _steps(6)]
    for height in np.sin(np.radians([-60, -30, 0, 30, 60])):
        wide = np.sqrt(1.0 - height**2)
        circles.append(np.stack([wide * np.cos(turn), wide * np.sin(turn), np.full_like(turn, height)], -1))
    for circle in circles:
        draw_path(axes, circle, "#dcdbe6", 0.8, view, zorder=1)


def _steps(count: int) -> Array:
    return np.arange(count) * np.pi / count


def draw_path(
    axes: Axes, points: Array, color: str, width: float, view: Rotation, zorder: float, label: str | None = None
) -> None:
    """Draw a path on the sphere, solid in front and faint behind."""
    seen = view.apply(points)
    front = np.where(seen[:, 2:] >= -1e-9, seen, np.nan)
    behind = np.where(seen[:, 2:] < 0.0, seen, np.nan)
    axes.plot(*behind[:, :2].T, color=color, lw=width, alpha=0.35, zorder=zorder - 0.5, solid_capstyle="round")
    axes.plot(*front[:, :2].T, color=color, lw=width, zorder=zorder, solid_capstyle="round", label=label)


def draw_keys(axes: Axes, points: Array, view: Rotation) -> None:
    """Draw keys as dots."""
    axes.plot(*view.apply(points)[:, :2].T, "o", color=INK, mec="white", mew=1.5, ms=9, zorder=9)


def geodesics() -> Figure:
    """Draw geodesics between the same two rotations, for several metrics, sides, and tilts of the axes."""
    axis = np.array([-0.25, 0.6, 0.76])
    end = Rotation.from_rotvec(np.radians(140.0) * axis / np.linalg.norm(axis))
    keys = turning(np.array([[0.0, 0.0, 0.0, 1.0], end.as_quat()]), np.array([0.0, 1.0]))
    times = np.linspace(0.0, 1.0, 201)
    view = facing(tips(interpolate(keys, times, "slerp")))
    shades = [matplotlib.colors.to_hex(shade) for shade in matplotlib.colormaps["plasma"](np.linspace(0.0, 0.85, 5))]
    pairs = [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (0.25, 1.0), (4.0, 0.25)]
    tilts = [np.radians(tilt) * np.array([[0.6, 0.0, 0.8]]) for tilt in (0.0, 22.5, 45.0, 67.5, 90.0)]
    rows: list[tuple[str, str, list[tuple[str, str, MetricParameters]]]] = []
    for side in ("left", "right"):
        metrics = [MetricParameters([alpha], [beta], invariance=side) for alpha, beta in pairs]
        words = [f"{alpha:g}, {beta:g}" for alpha, beta in pairs]
        rows.append((f"{side}-invariant", "alpha, beta", list(zip(words, (TRUTH, *_PALETTE), metrics, strict=True))))
    metrics = [MetricParameters([6.0], [0.5], axes=tilt) for tilt in tilts]
    words = [f"{np.degrees(np.linalg.norm(tilt)):g}°" for tilt in tilts]
    rows.append(("left-invariant, alpha 6, beta 0.5", "axes tilted by", list(zip(words, shades, metrics, strict=True))))
    figure = Figure(figsize=(11.0, 4.9), layout="constrained")
    for axes, (title, legend, curves) in zip(figure.subplots(1, 3), rows, strict=True):
        draw_sphere(axes, view)
        for word, color, metric in curves:
            plain = color == TRUTH
            path = interpolate(keys, times, "geodesic", metric)
            draw_path(axes, tips(path), color, 6.0 if plain else 2.4, view, 4.0 if plain else 5.0, word)
            if not plain:
                axes.plot(*view.apply(tips(path)[20:-1:20])[:, :2].T, ".", color=color, ms=7, zorder=6)
        draw_keys(axes, tips(keys), view)
        axes.set_title(title, color=INK)
        axes.legend(loc="upper center", ncol=3, bbox_to_anchor=(0.5, 0.0), frameon=False, title=legend, fontsize=10)
    return figure


def tension() -> Figure:
    """Draw an arm of the pitching clip through some of its keys, by tension: path and angular speed."""
    whole = joint_of(clip("pitching"), INDEX["RightUpperArm"])
    kept = uniform_keyframes(whole.n_frames, 0.2)[14:21]
    keys = whole.at_frames(kept)
    truth = whole.at_frames(slice(kept[0], kept[-1] + 1))
    times = np.union1d(keys.times, np.linspace(keys.times[0], keys.times[-1], 1501))
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.0, 1.35], height_ratios=[2.2, 1.0])
    sphere, speed, bends = (
        figure.add_subplot(grid[:, 0]),
        figure.add_subplot(grid[0, 1]),
        figure.add_subplot(grid[1, 1]),
    )
    view = facing(tips(truth))
    draw_sphere(sphere, view)
    draw_path(sphere, tips(truth), TRUTH, 7.0, view, 3, "original")
    metric = MetricParameters.identity(1)
    for amount, color in zip((0.0, 1.0, 2.0), (_PALETTE[0], _PALETTE[1], _PALETTE[2]), strict=True):
        learned = LearnedMetric(["joint"], metric, [amount], "geodesic-spline", translation_tension=[amount])
        path = interpolate(keys, times, "geodesic-spline", learned)
        draw_path(sphere, tips(path), color, 2.2, view, 5, f"tension {amount:g}")
        turns = Rotation.from_quat(path.rotations[:, 0])
        rate = np.degrees((turns[:-1].inv() * turns[1:]).magnitude()) / np.diff(times)
        speed.plot(0.5 * (times[1:] + times[:-1]), rate, color=color, lw=1.8)
    turns = Rotation.from_quat(truth.rotations[:, 0])
    rate = np.degrees((turns[:-1].inv() * turns[1:]).magnitude()) / np.diff(truth.times)
    speed.plot(0.5 * (truth.times[1:] + truth.times[:-1]), rate, color=TRUTH, lw=5.0, zorder=0, solid_capstyle="round")
    draw_keys(sphere, tips(keys), view)
    sphere.legend(loc="lower center", ncol=2, bbox_to_anchor=(0.5, -0.16), frameon=False)
    for time in keys.times:
        speed.axvline(time, color=FAINT, lw=0.8, ls=":", zorder=-1)
    speed.set(ylabel="degrees per second", xlabel="seconds; keys are dotted", ylim=(0.0, None))
    share = np.linspace(0.0, 1.0, 201)
    first, second = hermite(share)
    bends.plot(share, first, color=_PALETTE[1], lw=1.8)
    bends.plot(share, second, color=_PALETTE[2], lw=1.8)
    bends.text(0.33, 0.075, "$u\\,(1-u)^2$", color=_PALETTE[1], ha="center")
    bends.text(0.67, -0.1, "$-u^2\\,(1-u)$", color=_PALETTE[2], ha="center")
    bends.set(xlabel="u, share of a segment", xlim=(0, 1), yticks=[0.0], ylabel="weights of c")
    return figure


def landscape() -> Figure:
    """Draw the error of one joint by alpha and beta, for both sides, and what the gradient search finds."""
    whole = joint_of(clip("pitching"), INDEX["RightUpperArm"])
    kept = uniform_keyframes(whole.n_frames, 0.1)
    keys = whole.at_frames(kept)
    exponents = np.linspace(-2.3, 2.3, 41)
    slerp = quality(interpolate(keys, whole.times, "slerp"), whole, "rot")
    figure = Figure(figsize=(11.0, 4.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, side in zip(panels, ("left", "right"), strict=True):
        share = np.empty((len(exponents), len(exponents)))
        for row, b in enumerate(exponents):
            for column, a in enumerate(exponents):
                metric = MetricParameters([np.exp(a)], [np.exp(b)], invariance=side)
                share[row, column] = quality(interpolate(keys, whole.times, "geodesic", metric), whole, "rot") / slerp
        levels = np.arange(np.floor(share.min() * 50.0) / 50.0, 1.2, 0.02)
        filled = axes.contourf(exponents, exponents, share, levels, cmap="PuOr_r", extend="max", vmin=0.85, vmax=1.15)
        axes.contour(exponents, exponents, share, [1.0], colors=[INK], linewidths=1.2)
        found = learn_metric(whole, kept, invariance=side, scheme="geodesic", kind="rot")
        best = np.log([found.parameters.alpha[0], found.parameters.beta[0]])
        worth = found.provenance["score"] / slerp
        axes.plot(0.0, 0.0, "D", color=look("slerp").color, mec="white", ms=10)
        axes.annotate("slerp", (0.0, 0.0), (8, 8), textcoords="offset points", weight="bold")
        axes.plot(*best, "o", color=look("geodesic").color, mec="white", ms=11, clip_on=False)
        axes.set_title(f"{side}-invariant; learned: {100.0 * worth:.1f} % of slerp's error", color=INK)
        axes.set(xlabel="alpha", aspect="equal")
        ticks = [0.125, 0.25, 0.5, 1, 2, 4, 8]
        axes.set_xticks(np.log(ticks), [f"{tick:g}" for tick in ticks])
        axes.set_yticks(np.log(ticks), [f"{tick:g}" for tick in ticks])
    panels[0].set_ylabel("beta")
    bar = figure.colorbar(filled, ax=panels, shrink=0.9)
    bar.set_label("Q_rot as a share of slerp's")
    bar.outline.set_visible(False)
    return figure


def rates() -> Figure:
    """Draw the error of every scheme by the share of frames kept, mean over the example clips."""
    clips = [clip(name) for name in MOTIONS]
    shares = [0.5, 0.3, 0.2, 0.1, 0.05]
    names = ("constant", "linear", "slerp", "squad", "rotation-spline", "geodesic", "geodesic-spline")
    score = np.empty((len(names), len(shares), len(clips)))
    for number, animation in enumerate(clips):
        for column, share in enumerate(shares):
            kept = uniform_keyframes(animation.n_frames, share)
            for row, name in enumerate(names):
                metric = learn_metric(animation, kept, scheme=name) if name.startswith("geodesic") else None
                rebuilt = interpolate(animation.at_frames(kept), animation.times, name, metric)
                score[row, column, number] = quality(rebuilt, animation)
        print(f"  {list(MOTIONS)[number]}", flush=True)
    figure = Figure(figsize=(11.0, 4.2), layout="constrained")
    absolute, relative = figure.subplots(1, 2)
    percent = 100.0 * np.array(shares)
    for row, name in enumerate(names):
        style = look(name)
        line = {"color": style.color, "marker": style.marker, "lw": 1.8, "ms": 6}
        absolute.plot(percent, score[row].mean(axis=1), label=name, **line)
        if name != "constant":
            relative.plot(percent, 100.0 * (score[row] / score[2]).mean(axis=1), **line)
    for axes in (absolute, relative):
        axes.set_xscale("log")
        axes.set_xticks(percent, [f"{share:g}" for share in percent])
        axes.minorticks_off()
        axes.set_xlabel("frames kept, %")
    absolute.set(yscale="log", ylabel="Q_hyb, mean of five clips")
    relative.set(ylabel="Q_hyb, % of slerp's")
    absolute.legend(frameon=False, fontsize=9.5)
    return figure


def keys() -> Figure:
    """Draw the error of the pitching clip by the share of frames kept, uniform or chosen, and where chosen keys are."""
    animation = clip("pitching")
    shares = [0.3, 0.2, 0.1, 0.05]
    score: dict[str, list[float]] = {}

    def add(name: str, scheme: str, kept: np.ndarray, metric: LearnedMetric | None) -> None:
        rebuilt = interpolate(animation.at_frames(kept), animation.times, scheme, metric)
        score.setdefault(name, []).append(quality(rebuilt, animation))

    for share in shares:
        kept = uniform_keyframes(animation.n_frames, share)
        add("slerp, uniform", "slerp", kept, None)
        add("slerp, chosen", "slerp", optimal_keyframes(animation, len(kept)), None)
        metric = learn_metric(animation, kept, family="spd", scheme="geodesic-spline")
        add("geodesic-spline, uniform", "geodesic-spline", kept, metric)
        both = compress([animation], counts=[len(kept)])
        add("geodesic-spline, chosen", "geodesic-spline", both.keyframes[0], both.metric)
        if share == 0.1:
            rows = {"chosen": both.keyframes[0], "uniform": kept}
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    errors, places = figure.subplots(1, 2, width_ratios=[1.0, 1.2])
    for name, values in score.items():
        style = look(name.split(",")[0])
        line = "-" if name.endswith("chosen") else ":"
        errors.plot(100.0 * np.array(shares), values, line, color=style.color, marker=style.marker, ms=6, label=name)
    errors.set(xscale="log", yscale="log", xlabel="frames kept, %", ylabel="Q_hyb")
    errors.set_xticks([100.0 * share for share in shares], [f"{100.0 * share:g}" for share in shares])
    errors.minorticks_off()
    errors.legend(frameon=False, fontsize=9.5)
    steps = distance(animation.rotations[1:], animation.rotations[:-1]).mean(axis=1)
    places.fill_between(animation.times[1:], np.degrees(steps) * RATE, color=TRUTH, alpha=0.6, lw=0)
    low = -0.1 * float(np.degrees(steps).max() * RATE)
    for row, (name, kept) in enumerate(rows.items()):
        height = (1.0 + row) * low
        color = look("geodesic-spline").color if name == "chosen" else FAINT
        places.plot(animation.times[kept], np.full(len(kept), height), "o", color=color, ms=6)
        places.text(animation.times[-1] * 1.02, height, name, color=color, va="center")
    places.set(xlabel="seconds", ylabel="mean angular speed, degrees per second")
    places.set_yticks([tick for tick in places.get_yticks() if tick >= 0.0 and tick < -10.5 * low])
    return figure


def contacts() -> Figure:
    """Draw how far the feet of the pitcher are from their places, rebuilt from a tenth of the frames."""
    animation, up = clip("pitching"), np.array([0.0, 1.0, 0.0])
    found = find_contacts(animation, up)
    keys = animation.at_frames(uniform_keyframes(animation.n_frames, 0.1))
    plants = Plants.of(found, animation).through_keys(keys)
    times = np.union1d(animation.times, plants.probes())
    spline = interpolate(keys, times)
    rows = {
        "slerp": (interpolate(keys, times, "slerp"), look("slerp").color),
        "spline": (spline, FAINT),
        "spline, --contacts": (
            plant(spline, keys, plants, MetricParameters.identity(animation.n_joints)).animation,
            look("geodesic-spline").color,
        ),
    }
    figure = Figure(figsize=(11.0, 4.2), layout="constrained")
    feet = [
        list(animation.skeleton.joints).index(joint) for joint in animation.skeleton.joints if joint.endswith("Foot")
    ]
    for axes, foot in zip(figure.subplots(len(feet), 1, sharex=True), feet, strict=True):
        truth = world_places(interpolate(animation, times, "linear"), foot)
        planted = found.planted[:, found.joints == foot].any(axis=1)
        for start in np.flatnonzero(planted):
            axes.axvspan(*animation.times[start : start + 2], color=TRUTH, alpha=0.25, lw=0)
        for name, (motion, color) in rows.items():
            away = 100.0 * np.linalg.norm(world_places(motion, foot) - truth, axis=-1)
            axes.plot(times, away, color=color, lw=1.8, label=name)
        axes.plot(keys.times, np.zeros(keys.n_frames), "o", color=INK, ms=4, clip_on=False)
        axes.set(ylabel=f"{animation.skeleton.joints[foot].rsplit('/', 1)[-1]}, cm", ylim=(0.0, None))
    axes.set_xlabel("seconds")
    figure.axes[0].legend(frameon=False, fontsize=9.5)
    return figure


def world_places(animation: Animation, joint: int) -> Array:
    """Return where a joint is in each frame, metres, shape=[F, 3]."""
    return joint_matrices(animation)[:, joint, :, 3]


FIGURES: dict[str, Callable[[], Figure]] = {
    "geodesics": geodesics,
    "tension": tension,
    "landscape": landscape,
    "rates": rates,
    "keys": keys,
    "contacts": contacts,
}


def main(argv: list[str] | None = None) -> int:
    """Draw the figures that are named, or all, and print their paths."""
    parser = argparse.ArgumentParser(prog="make_figures.py", description=__doc__)
    parser.add_argument("figures", metavar="NAME", nargs="*", choices=list(FIGURES), default=[], help="default: all")
    parser.add_argument("--format", choices=("svg", "png"), default="svg")
    parser.add_argument("-o", "--out", metavar="FOLDER", type=Path, default=_HERE / "images")
    arguments = parser.parse_args(argv)
    for name in arguments.figures or FIGURES:
        with matplotlib.rc_context(_STYLE):
            path = arguments.out / f"{name}.{arguments.format}"
            metadata = {"Date": None} if arguments.format == "svg" else {}
            FIGURES[name]().savefig(path, metadata=metadata, facecolor="white", dpi=100, bbox_inches="tight")
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
