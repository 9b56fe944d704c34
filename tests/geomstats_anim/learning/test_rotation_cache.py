"""What is remembered is what would be rebuilt, and what is not new is not rebuilt."""

import numpy as np
from wanderings import N_JOINTS, metric

from geomstats_anim.learning.rotation_cache import RotationMemory
from geomstats_anim.parameters import CurveParameters


class Builder:
    """Rotations that tell the numbers they were made of, and a list of the joints they were made for."""

    def __init__(self):
        self.asked = []

    def __call__(self, curve, joints):
        self.asked.append(joints.tolist())
        numbers = np.stack([curve.metric.alpha, curve.metric.beta, curve.metric.is_right, curve.tension], axis=-1)
        return numbers + np.arange(5)[:, None, None]


def curve(seed, full=False):
    tension = np.random.default_rng(seed).uniform(0.0, 2.0, N_JOINTS)
    return CurveParameters(metric(seed, full), tension, tension)


def mixed(one, other, joints):
    """The first curve, but for some joints."""
    sides = [other.metric.invariance[b] if b in joints else one.metric.invariance[b] for b in range(N_JOINTS)]
    alpha, beta, tension = (
        np.where(np.isin(np.arange(N_JOINTS), joints), theirs, mine)
        for mine, theirs in (
            (one.metric.alpha, other.metric.alpha),
            (one.metric.beta, other.metric.beta),
            (one.tension, other.tension),
        )
    )
    return CurveParameters(type(one.metric)(alpha, beta, None, tuple(sides)), tension, tension)


def test_it_returns_what_would_be_rebuilt():
    rng, memory, builder = np.random.default_rng(0), RotationMemory(), Builder()
    curves = [curve(seed) for seed in range(5)]
    for _ in range(50):
        one, other = rng.choice(5, 2)
        wanted = mixed(curves[one], curves[other], rng.choice(N_JOINTS, 3, replace=False))
        expected = Builder()(wanted, np.arange(N_JOINTS))
        np.testing.assert_array_equal(memory.recall(wanted, builder), expected)


def test_only_new_joints_are_rebuilt():
    memory, builder = RotationMemory(), Builder()
    one, other = curve(1), curve(2)
    memory.recall(one, builder)
    memory.recall(other, builder)
    memory.recall(mixed(one, curve(3), [2, 4]), builder)
    everything = list(range(N_JOINTS))
    assert builder.asked == [everything, everything, [2, 4]]
    for joint in range(N_JOINTS):
        memory.recall(mixed(one, other, [joint]), builder)
    assert builder.asked[3:] == [[]] * N_JOINTS


def test_axes_and_sides_count():
    memory, builder = RotationMemory(), Builder()
    straight, tilted = curve(4), curve(4, full=True)
    memory.recall(straight, builder)
    memory.recall(tilted, builder)
    assert builder.asked[1] == list(range(N_JOINTS))
