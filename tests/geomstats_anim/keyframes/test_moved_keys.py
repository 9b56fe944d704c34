"""Moving keys ends where no single key can be moved to advantage, and never makes them worse."""

import numpy as np
import pytest

from geomstats_anim.keyframes.local_search import moved

N_FRAMES = 60


def judge_of(values):
    """Squared error of every frame, rebuilt by straight lines between keys."""

    def judge(keys):
        assert (np.diff(keys) > 0).all()
        return (np.interp(np.arange(N_FRAMES), keys, values[keys]) - values) ** 2

    return judge


def cheapest_neighbour(judge, keys, fixed):
    """Least cost of keys of which one is moved by a frame or two."""
    costs = [np.inf]
    for place in np.flatnonzero(~np.isin(keys, fixed)):
        for step in (-2, -1, 1, 2):
            other = keys.copy()
            other[place] += step
            if (np.diff(other) > 0).all():
                costs.append(judge(other).sum())
    return min(costs)


@pytest.mark.parametrize("seed", range(12))
def test_no_single_move_helps(seed):
    rng = np.random.default_rng(seed)
    values = np.cumsum(np.cumsum(rng.normal(size=N_FRAMES)))
    judge = judge_of(values)
    keys = np.linspace(0, N_FRAMES - 1, 12).round().astype(int)
    keys[1:-1] += rng.integers(-2, 3, size=10)
    fixed = keys[[0, 5, -1]]
    found = moved(judge, keys, fixed, rounds=100)
    assert len(found) == len(keys) and np.isin(fixed, found).all()
    cost = judge(found).sum()
    assert cost <= judge(keys).sum()
    assert cheapest_neighbour(judge, found, fixed) >= 0.97 * cost
