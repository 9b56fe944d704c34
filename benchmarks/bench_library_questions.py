"""Variants of libraries of in-betweens that are not in the program, with what they bring: one line for each question.

    python benchmarks/bench_library_questions.py

Reads the clips of ../shared/data/library/bandai. Known actions: every third clip of five styles, by a library of the
others (walks, runs, dashes); unseen: every third walk, by a library without walks. Of the network and of
hips the raw predictions are scored, before any guard: what is left of the weights of sines, or of the path. Feet that
are kept planted are scored with the translations of the rebuilt clips, since planting may move the hips.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from bench_contacts import clip_of, kept
from bench_geodesics import Line, print_table
from bench_library import (
    ACTIONS,
    DATA,
    GAPS,
    RATES,
    STYLES,
    best_free,
    errors,
    free_errors,
    keys_of,
    learned_errors,
    pair,
    ratios,
    read,
)
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor

sys.path.insert(0, str(Path(__file__).parents[1]))

from geomstats_anim import Animation, interpolate, learn_library, optimal_keyframes  # noqa: E402
from geomstats_anim import rotations as quat  # noqa: E402
from geomstats_anim.contacts import Contacts, Plants, find_contacts, skating  # noqa: E402
from geomstats_anim.criteria import rotation_errors  # noqa: E402
from geomstats_anim.interpolation.learned_scheme import Learned  # noqa: E402
from geomstats_anim.kinematics import place  # noqa: E402
from geomstats_anim.learning.library.context import contexts_of  # noqa: E402
from geomstats_anim.learning.library.motion_library import MotionLibrary  # noqa: E402
from geomstats_anim.learning.library.regression import Regression, weights_of  # noqa: E402
from geomstats_anim.learning.library.samples import Samples, samples_of  # noqa: E402
from usd_tools.upsampling.contacts import REACH  # noqa: E402

GAP = 10
Clips = list[Animation]


def splits() -> tuple[tuple[Clips, Clips], tuple[Clips, Clips]]:
    """Return library and held-out clips, for known actions and for an unseen one."""
    clips = read("bandai")
    moving = {name: clip for name, clip in clips.items() if name.split("_")[0] not in ("bow", "guide")}
    known = known_names(clips)
    walks = [name for name in clips if name.split("_")[0] in ACTIONS["walks"]]
    return (
        ([moving[name] for name in moving if name not in known], [clips[name] for name in known[::3]]),
        ([clips[name] for name in clips if name not in walks], [clips[name] for name in walks[::3]]),
    )


def known_names(names: Iterable[str]) -> list[str]:
    """Take the names of walks, runs and dashes of held-out styles."""
    split = {name: name.split("_") for name in names}
    return [name for name, words in split.items() if words[0] not in ("bow", "guide") and words[1] in STYLES]


def left(true: np.ndarray, predicted: np.ndarray) -> float:
    """Return what is left of residuals, shape=[n, ...], as a share of them."""
    return float(np.linalg.norm(true - predicted, axis=-1).mean() / np.linalg.norm(true, axis=-1).mean())


def network(library: MotionLibrary, rest: Clips, held: Clips) -> tuple[float, float, float]:
    """Return what the kernel regression, a network of 2 x 256 and their mean leave of the residuals."""
    (model,), parts = library.models, library.parts
    train, test = (samples_of(clips, GAP, parts.trunk, library.vertical) for clips in (rest, held))
    assert train is not None and test is not None

    def inputs(samples: Samples) -> tuple[np.ndarray, np.ndarray]:
        scales = samples.contexts.scales(parts)
        features = np.concatenate(model.features(samples.contexts, scales), axis=1)
        return features, scales[:, parts.of_joint][:, None, :, None]

    (x, scale), (z, unit) = inputs(train), inputs(test)
    net = MLPRegressor(hidden_layer_sizes=(256, 256), alpha=1e-3, max_iter=40, early_stopping=True, random_state=0)
    warnings.simplefilter("ignore", ConvergenceWarning)  # stopped early on purpose
    net.fit(x, (train.sines / scale).reshape(len(x), -1))
    by_net = net.predict(z).reshape(test.sines.shape) * unit
    by_kernel = model.predict(test.contexts)
    return tuple(left(test.sines, each) for each in (by_kernel, by_net, 0.5 * (by_kernel + by_net)))  # type: ignore


def hips(library: MotionLibrary, rest: Clips, held: Clips) -> float:
    """Return what a regression on the features of the torso leaves of the hips' path, off the cubic spline."""
    (model,), parts = library.models, library.parts

    def missed(clips: Clips) -> tuple[np.ndarray, np.ndarray]:
        paths, features = [], []
        for clip in clips:
            samples = samples_of([clip], GAP, parts.trunk, library.vertical)
            if samples is None:
                continue
            for phase in range(0, GAP, 2):
                keys = np.arange(phase, clip.n_frames, GAP)
                if len(keys) < 3:
                    continue
                middle = keys[:-1] + GAP // 2
                dense = interpolate(clip.at_frames(keys), clip.times[middle])
                joint = parts.trunk[-1]
                off = clip.translations[middle, joint] - dense.translations[:, joint]
                paths.append(quat.rotate(quat.conjugate(dense.rotations[:, joint]), off))
                at = contexts_of(clip.times[keys], clip.rotations[keys], parts.trunk, library.vertical)
                features.append(model.features(at, at.scales(parts)))
        return np.concatenate(paths), np.concatenate(features, axis=1)

    (path, features), (goal, others) = missed(rest), missed(held)
    factor = model.centres.factors[0]
    weights = weights_of(Regression(model.centres.kernels(features)[0], factor, path).whitened_weights(), factor)
    return left(goal, model.centres.kernels(others)[0] @ weights)


def planting(library: MotionLibrary, names: Iterable[str]) -> Iterator[Line]:
    """Score the spline and a library, each as it is and with points kept planted, as keys or as the clips tell."""
    clips = [clip_of(DATA / "bandai" / f"{name}.usdc") for name in names]
    for rate in RATES:
        rows: dict[str, list[tuple[float, float, float]]] = {}
        for clip, up in clips:
            keys, contacts = keys_of(clip, rate), find_contacts(clip, up)
            of_keys = Plants.of(find_contacts(keys, up), keys).through_keys(keys)
            of_clip = Plants.of(contacts, clip).through_keys(keys)
            for word, curve in (("spline", Learned(keys)), ("learned", Learned(keys, None, library))):
                for suffix, rebuilt in (
                    ("", curve(clip.times)),
                    (", contacts of the keys", kept(clip, curve, of_keys, 0.01 * REACH)[0]),
                    (", contacts of the clip", kept(clip, curve, of_clip, np.inf)[0]),
                ):
                    rows.setdefault(word + suffix, []).append(planted_errors(rebuilt, clip, contacts))
        base = np.array(rows["spline"])[:, :2]
        for words, found in rows.items():
            skate = np.nanmean(np.array(found)[:, 2])
            ratio = pair((np.array(found)[:, :2] / base).mean(axis=0))
            yield Line(
                f"known actions, rate {rate:g}, {words}: to the spline; cm/s of skate", "", f"{ratio}; {skate:.1f}"
            )


def planted_errors(rebuilt: Animation, original: Animation, contacts: Contacts) -> tuple[float, float, float]:
    """Return the mean angle, the mean distance of bone ends, and the skate of what is planted in the original."""
    ends = [place(each.skeleton, each.rotations, each.translations).ends for each in (rebuilt, original)]
    found = skating([rebuilt], [original], [contacts])
    return (
        float(rotation_errors(rebuilt, original).mean()),
        float(np.linalg.norm(ends[0] - ends[1], axis=-1).mean()),
        float("nan") if found is None else found.skate,
    )


def measure(quick: bool) -> Iterator[Line]:
    """Measure everything."""
    known, unseen = splits()
    for words, (rest, held) in (("known actions", known), ("walks, unseen", unseen)):
        library = learn_library(rest, gaps=(GAP,))
        found = network(library, rest, held)
        yield Line(
            f"{words}: residual left by kernels / network / their mean", "", " / ".join(f"{x:.3f}" for x in found)
        )
        yield Line(
            f"{words}: path of the hips left by the kernels of the torso", "", f"{hips(library, rest, held):.3f}"
        )
    rest, held = known
    yield from planting(learn_library(rest, gaps=GAPS), known_names(read("bandai"))[::3])
    library = learn_library(rest, gaps=(5, 6, 8, 10, 12, 16, 20, 24, 32, 40))
    _, said = ratios(learned_errors(library, held, 0.05), best_free(free_errors(held, 0.05)))
    yield Line("known actions, a key every 20 frames, checked at 40: to the best scheme", "", said)
    yield from choosing(library, held[:6])


def choosing(library: MotionLibrary, held: Clips) -> Iterator[Line]:
    """Score a tenth of the frames: uniform ones, those chosen for the spline, and from there those for the library."""
    found: dict[str, list[np.ndarray]] = {}
    for clip in held:
        count = max(6, round(0.1 * clip.n_frames))
        uniform = np.round(np.linspace(0, clip.n_frames - 1, count)).astype(int)
        chosen = optimal_keyframes(clip, count, scheme="geodesic-spline")
        base = errors_of(clip, uniform, None)
        keys = {
            "uniform": uniform,
            "chosen for the spline": chosen,
            "... moved for the spline": moved(clip, chosen, None),
        }
        starts = [moved(clip, frames, library) for frames in (uniform, chosen)]
        keys["chosen for the library"] = min(starts, key=lambda frames: errors_of(clip, frames, library).sum())
        for name, frames in keys.items():
            pairs = np.array([errors_of(clip, frames, each) for each in (None, library)]) / base
            found.setdefault(name, []).append(pairs)
    for name, of_clips in found.items():
        words = "; ".join(pair(ratio) for ratio in np.mean(of_clips, axis=0))
        yield Line(f"a tenth of the frames, {name}: spline; learned, to the spline through uniform keys", "", words)


def errors_of(clip: Animation, frames: np.ndarray, library: MotionLibrary | None) -> np.ndarray:
    """Return the errors of a clip that is rebuilt from frames, shape=[2]."""
    return np.array(errors(Learned(clip.at_frames(frames), None, library)(clip.times), clip))


def moved(clip: Animation, frames: np.ndarray, library: MotionLibrary | None, sweeps: int = 3) -> np.ndarray:
    """Move inner keys by up to two frames, one by one, as long as the mean of both errors falls."""
    base = errors_of(clip, frames, library)
    best, cost = frames.copy(), 2.0
    for _ in range(sweeps):
        before = cost
        for key in range(1, len(frames) - 1):
            for step in (-2, -1, 1, 2):
                tried = best.copy()
                tried[key] = best[key] + step
                if (np.diff(tried) > 0).all() and (found := (errors_of(clip, tried, library) / base).sum()) < cost:
                    best, cost = tried, found
        if cost == before:
            break
    return best


if __name__ == "__main__":
    sys.exit(print_table(measure, __doc__, None))
