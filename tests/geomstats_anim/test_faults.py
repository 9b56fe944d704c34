"""Laws of what is found in recorded motion: all kinds of faults, and nothing in motion that is fast, held or keyed."""

import numpy as np
import pytest

from geomstats_anim import rotations as quat
from geomstats_anim.faults import fill, find_faults, mask_of
from geomstats_anim.names import DROPOUT, GAP, SPIKE
from geomstats_anim.spaces import Points, Turns

RATE = 30.0
N_FRAMES, N_JOINTS = 120, 4


def swinging(n_frames=N_FRAMES, rate=RATE, size=0.6, seed=0):
    """Unit quaternions of a smooth motion of about one cycle per second, shape=[F, N, 4]."""
    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0.0, 6.0, (N_JOINTS, 3)), rng.uniform(3.0, 8.0, (N_JOINTS, 3))
    seconds = np.arange(n_frames)[:, None, None] / rate
    return quat.exp(size * np.sin(speed * seconds + phase))


def found(values, space=None, rate=RATE, **options):
    return find_faults(values, np.arange(len(values)) / rate, Turns() if space is None else space, **options)


def turned(values, start, stop, joint, degrees, axis=(0.0, 0.6, 0.8)):
    """Turn samples of a joint away."""
    turn = quat.exp(np.radians(degrees) * np.array([axis]))
    values = values.copy()
    values[start:stop, joint] = quat.multiply(values[start:stop, joint], np.repeat(turn, stop - start, axis=0))
    return values


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("rate", [24.0, 60.0, 120.0])
def test_clean_motion_has_no_faults(seed, rate):
    assert found(swinging(rate=rate, seed=seed), rate=rate) == []
    path = np.cumsum(np.random.default_rng(seed).normal(size=(200, 3, 3)), axis=0)
    assert found(path, Points(1.0)) == []  # rough, but nothing stands out


@pytest.mark.parametrize("degrees", [40.0, 90.0, 180.0])
@pytest.mark.parametrize("length", [1, 2, 3])
@pytest.mark.parametrize("start", [1, 2, 60, N_FRAMES - 4])
def test_spikes(start, length, degrees):
    stop = min(start + length, N_FRAMES - 1)
    faults = found(turned(swinging(), start, stop, 2, degrees))
    assert [(each.kind, each.joint, each.start, each.stop) for each in faults] == [(SPIKE, 2, start, stop)]
    assert np.degrees(faults[0].size) == pytest.approx(degrees, abs=12.0)


def test_spikes_close_together_and_of_all_joints_at_once():
    values = swinging()
    for start in (30, 35, 40):
        values = turned(values, start, start + 1, 1, 120.0)
    for joint in range(N_JOINTS):
        values = turned(values, 80, 82, joint, 90.0)
    expected = [(30, 31, 1), (35, 36, 1), (40, 41, 1), *((80, 82, joint) for joint in range(N_JOINTS))]
    assert [(each.start, each.stop, each.joint) for each in found(values, parents=np.arange(-1, 3))] == expected


def test_a_flip_by_half_a_turn_may_last():
    values = turned(swinging(), 40, 52, 0, 176.0)
    assert [(each.kind, each.start, each.stop) for each in found(values)] == [(SPIKE, 40, 52)]
    assert found(turned(swinging(), 40, 70, 0, 176.0)) == []  # a second: the joint may be so
    assert found(turned(swinging(), 40, N_FRAMES, 0, 176.0)) == []  # it does not come back


@pytest.mark.parametrize("length", [2, 3, 9])
def test_drop_outs(length):
    values = swinging()
    values[50 : 50 + length, 1] = values[49, 1]
    values[50 : 50 + length, 3] = -values[49, 3]  # the same rotation
    faults = found(values)
    assert {(each.kind, each.joint, each.start, each.stop) for each in faults} <= {
        (DROPOUT, joint, 50, 50 + length) for joint in (1, 3)
    }
    assert len(faults) == 2


def test_a_drop_out_to_another_value():
    values = swinging()
    values[50:58, 1] = quat.multiply(values[49:50, 1], quat.exp(np.array([[2.0, 0.0, 0.0]])))
    assert [(each.kind, each.joint, each.start, each.stop) for each in found(values)] == [(DROPOUT, 1, 50, 58)]


@pytest.mark.parametrize("ease", [1, 2, 3])
def test_poses_that_are_held_are_no_faults(ease):
    """Held for ten samples, left and reached linearly, quadratically, cubically; and with a step, as stepped keys."""
    away = np.linspace(0.0, 1.0, 15) ** ease
    angles = np.concatenate([away[::-1], np.zeros(10), away, np.ones(10), away[::-1]])
    still = quat.exp(np.stack([angles, 0.0 * angles, 0.0 * angles], axis=-1))[:, None]
    assert found(still) == []
    lands = np.concatenate([np.cumsum([0.1, 23.0, 18.0, 1.8]), np.full(11, 42.9), 42.9 - np.cumsum([6.6, 15.4, 14, 3])])
    assert found(quat.exp(np.radians(lands)[:, None, None] * [[[1.0, 0.0, 0.0]]])) == []  # toes in flight
    stepped = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, 20), 3)
    assert found(quat.exp(np.stack([stepped, stepped, stepped], axis=-1))[:, None]) == []


def test_a_pose_that_pops_after_a_hold_is_no_drop_out():
    angles = np.concatenate([np.linspace(0.0, 0.1, 20), np.full(5, 0.1), 2.5 + np.linspace(0.0, 0.1, 20)])
    assert found(quat.exp(np.stack([angles, 0.0 * angles, 0.0 * angles], axis=-1))[:, None]) == []


def test_a_limb_that_strikes_moves_with_its_chain():
    """A wrist that swings out and back within three samples is no spike where its arm moves as fast."""
    values = swinging(size=0.2)
    swing = np.radians([0.0, 85.0, 10.0])
    alone = values.copy()
    alone[60:63, 2] = quat.multiply(values[60:63, 2], quat.exp(swing[:, None] * [[0.0, 0.0, 1.0]]))
    together = alone.copy()
    together[61:, 1] = quat.multiply(values[61:, 1], quat.exp(np.radians([[0.0, 0.0, 120.0]])))
    parents = np.array([-1, 0, 1, 2])
    assert [each.joint for each in found(alone, parents=parents)] == [2]
    assert found(together, parents=parents) == []


def test_gaps_are_the_runs_of_what_is_missing_and_nothing_is_found_beside_them():
    missing = np.zeros((N_FRAMES, N_JOINTS), dtype=bool)
    missing[10:14, 0] = missing[0:3, 2] = missing[117:, 2] = True
    values = turned(swinging(), 14, 15, 0, 90.0)  # it may be a spike, but what is before it is not known
    faults = found(fill(values, np.arange(120.0), Turns(), missing), missing=missing)
    places = [(each.kind, each.joint, each.start, each.stop) for each in faults]
    assert places == [(GAP, 2, 0, 3), (GAP, 0, 10, 14), (GAP, 2, 117, 120)]
    assert all(np.isnan(each.size) for each in faults)
    assert (mask_of(faults, N_FRAMES, N_JOINTS) == missing).all()


def test_filling_in_is_the_shortest_way_in_time():
    times = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])
    mask = np.array([1, 0, 1, 1, 0, 1], dtype=bool)[:, None]
    values = np.array([9.0, 2.0, 9.0, 9.0, 10.0, 9.0])[:, None, None]
    assert fill(values, times, Points(1.0), mask).ravel().tolist() == [2.0, 2.0, 4.0, 8.0, 10.0, 10.0]
    turns = quat.exp(np.radians([0.0, 10.0, 9.0, 9.0, 40.0, 9.0])[:, None, None] * [[[1.0, 0.0, 0.0]]])
    turns[4] *= -1.0
    angles = np.degrees(quat.angle(fill(turns, times, Turns(), mask)))
    np.testing.assert_allclose(angles.ravel(), [10.0, 10.0, 17.5, 32.5, 40.0, 40.0], atol=0.3)


def test_nothing_depends_on_units_signs_lengths_or_the_frame():
    values = turned(swinging(), 40, 42, 3, 100.0)
    values[60:66, 1] = values[59, 1]
    expected = found(values)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], values.shape[:2])[..., None]
    left = quat.multiply(np.broadcast_to(quat.exp(np.array([0.3, 0.2, -1.0])), values.shape).copy(), values)
    for other in (signs * values, 2.0 * values, values.astype(np.float32), left):
        # turning rounds; what is held still is in the same bits
        assert [(each.kind, each.start, each.stop, each.joint) for each in found(other)] == [
            (each.kind, each.start, each.stop, each.joint) for each in expected
        ]
    path = values[..., :3]
    assert found(path, Points(0.5)) == found(100.0 * path, Points(50.0))


def test_noise_is_no_fault_and_takes_no_time():
    rng = np.random.default_rng(0)
    assert found(quat.normalize(rng.normal(size=(3000, 20, 4)))) == []
    assert found(np.zeros((0, 2, 3)), Points(1.0)) == found(np.zeros((1, 2, 3)), Points(1.0)) == []


def test_a_joint_at_rest_that_flips_comes_back_to_where_it_was():
    still = np.tile(quat.IDENTITY, (60, 1, 1))
    assert [(each.start, each.stop) for each in found(turned(still, 20, 23, 0, 90.0))] == [(20, 23)]
    assert found(turned(still, 20, 23, 0, 30.0)) == []  # an eye that blinks
    assert found(turned(turned(still, 20, 23, 0, 90.0), 23, 60, 0, 5.0)) == []  # stepped keys
