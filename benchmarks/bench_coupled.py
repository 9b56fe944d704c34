"""Print what metrics over the whole pose, and of rigid motions, bring on the example clips: docs/geomstats.rst."""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "notebooks"))

from drawing import clip  # noqa: E402

from geomstats_anim import PoseSpace, interpolate, learn_metric, uniform_keyframes  # noqa: E402
from geomstats_anim import rotations as quat  # noqa: E402
from geomstats_anim.interpolation.curves import locate  # noqa: E402
from geomstats_anim.riemannian.coupled import CoupledPoseMetric, matrix_of_motion  # noqa: E402

RATE = 0.1
SHRINKAGES = (1.0, 0.1)


def error(rotations, truth):
    """Return the mean rotation error in degrees."""
    return float(np.degrees(quat.distance(rotations, truth)).mean())


def rebuilt(space, animation, keys):
    """Return rotations along geodesics between keys, and the time of a logarithm."""
    points = quat.to_matrix(animation.rotations[keys])
    start = time.process_time()
    vectors = space.metric.log(points[1:], points[:-1])
    seconds = (time.process_time() - start) / len(vectors)
    frames = [points[:1]]
    for base, vector, begin, end in zip(points[:-1], vectors, keys[:-1], keys[1:], strict=True):
        times = np.arange(1, end - begin + 1) / (end - begin)
        frames.append(space.metric.geodesic(base, initial_tangent_vec=vector)(times))
    return quat.from_matrix(np.concatenate(frames)), seconds


def root_errors(animation, keys):
    """Return the mean error of the root's place, in centimetres: on straight lines, and about the best center of mass.

    Where the rotations are known, the place is linear in the center, so that least squares find it.
    """
    kept = animation.at_frames(keys)
    turns = quat.to_matrix(interpolate(kept, animation.times, "slerp").rotations[:, 0])
    segment, share = locate(kept.times, animation.times)
    share = share[:, None]

    def between(values):
        flat = values.reshape(len(values), -1)
        mixed = (1.0 - share) * flat[segment] + share * flat[segment + 1]
        return mixed.reshape(len(share), *values.shape[1:])

    places = animation.translations[:, 0]
    straight = between(places[keys])
    levers = between(turns[keys]) - turns  # of the center, in the error of the place
    center = np.linalg.lstsq(levers.reshape(-1, 3), (places - straight).ravel())[0]
    return [100.0 * np.linalg.norm(p - places, axis=-1).mean() for p in (straight, straight + levers @ center)]


def main():
    """Print both tables, of the clips that are named, or all."""
    names = sys.argv[1:] or ("jumping", "pitching", "punching", "rolling", "sitting")
    print("clip | root on straight lines, cm | about a center of mass, cm")
    for name in names:
        animation = clip(name)
        straight, bent = root_errors(animation, uniform_keyframes(animation.n_frames, RATE))
        print(f"{name} | {straight:.2f} | {bent:.2f}")
    print()
    print(
        "clip | slerp | diagonal | spd | coupled | seconds to learn it |",
        " | ".join(f"of motion, {share:g}" for share in SHRINKAGES),
        "| ms a log",
    )
    for name in names:
        animation = clip(name)
        keys = uniform_keyframes(animation.n_frames, RATE)
        kept = animation.at_frames(keys)
        figures = [error(interpolate(kept, animation.times, "slerp").rotations, animation.rotations)]
        for family in ("diagonal", "spd", "coupled"):
            start = time.process_time()
            metric = learn_metric(animation, keys, family=family, scheme="geodesic", kind="rot")
            learning = time.process_time() - start
            figures.append(error(interpolate(kept, animation.times, "geodesic", metric).rotations, animation.rotations))
        figures.append(learning)
        space = PoseSpace(animation.n_joints, equip=False)
        for shrinkage in SHRINKAGES:
            matrix = matrix_of_motion(quat.to_matrix(animation.rotations), shrinkage)
            space.equip_with_metric(CoupledPoseMetric, metric_mat_at_identity=matrix)
            rotations, seconds = rebuilt(space, animation, keys)
            figures.append(error(rotations, animation.rotations))
        words = " | ".join(f"{figure:.3f}" for figure in figures)
        print(f"{name} | {words} | {1e3 * seconds:.0f}", flush=True)


if __name__ == "__main__":
    main()
