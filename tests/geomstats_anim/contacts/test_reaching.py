"""Laws of the smallest correction."""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize
from walker import walk

from geomstats_anim import MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.contacts.reaching import Body
from geomstats_anim.markers import joint_matrices


def places_of(animation, body, frames):
    return joint_matrices(animation.at_frames(frames))[..., 3][:, body.joints[body.points]]


def test_the_correction_is_the_smallest_to_second_order():
    animation = walk(seconds=1.0, rate=10.0)[0]
    rng = np.random.default_rng(0)
    parameters = MetricParameters(rng.uniform(0.5, 4.0, 10), rng.uniform(0.5, 4.0, 10), rng.normal(size=(10, 3)))
    body = Body.of(animation, animation, np.array([3]), parameters, moves_root=False)
    frames = np.array([4])
    goal = places_of(animation, body, frames) + [[[0.004, 0.006, -0.003]]]
    rotations, translations = body.reached(frames, goal, np.ones((1, 1)))
    base = animation.rotations[frames][:, body.joints]
    found = quat.difference(base, rotations[:, body.joints])[0]
    costs = body.units @ body.units.swapaxes(-1, -2)  # all of this chain turn, so all are free

    def cost(vector):
        turns = vector.reshape(-1, 3)
        return np.einsum("ji,jik,jk->", turns, np.linalg.inv(costs), turns)

    def miss(vector):
        turned = quat.multiply(base, quat.exp(vector.reshape(1, -1, 3)))
        whole = np.array(animation.rotations[frames])
        whole[:, body.joints] = turned
        placed = places_of(replace(animation.at_frames(frames), rotations=whole), body, slice(None))
        return 1e3 * (placed - goal)[0, 0]

    best = minimize(cost, np.zeros(found.size), constraints={"type": "eq", "fun": miss}, method="SLSQP", tol=1e-12)
    assert best.success
    assert np.abs(miss(found.ravel())).max() < 1e-2  # micrometres
    assert cost(found.ravel()) < 1.01 * best.fun


def test_a_point_that_is_free_changes_nothing():
    animation = walk(seconds=1.0, rate=10.0)[0]
    body = Body.of(animation, animation, np.array([3, 7]), MetricParameters.identity(10), moves_root=True)
    frames = np.array([3, 4, 5])
    places = places_of(animation, body, frames)
    rotations, translations = body.reached(frames, places + 0.05, np.zeros((3, 2)))
    assert quat.distance(rotations, animation.rotations[frames]).max() < 1e-6
    np.testing.assert_allclose(translations, animation.translations[frames], atol=1e-8)


def test_the_root_moves_where_a_leg_is_too_short():
    animation = walk(seconds=1.0, rate=10.0)[0]
    body = Body.of(animation, animation, np.array([3]), MetricParameters.identity(10), moves_root=True)
    frames = np.array([4])
    place = places_of(animation, body, frames)
    moves = []
    for way in ([0.01, 0.0, 0.0], [0.0, -0.25, 0.0]):  # the leg is 0.9 metres long, and bent a little
        _, translations = body.reached(frames, place + way, np.ones((1, 1)))
        moves.append(np.linalg.norm((translations[0] - animation.translations[4])[body.joints[body.root]]))
    assert moves[0] < 0.2 * 0.01
    assert moves[1] > 0.1


def test_a_frame_is_corrected_by_itself():
    animation = walk(seconds=1.0, rate=10.0)[0]
    points, frames, rng = np.array([3, 7]), np.array([2, 4, 6]), np.random.default_rng(1)
    sides = ["left", "right"] * 5
    parameters = MetricParameters(rng.uniform(0.5, 4.0, 10), rng.uniform(0.5, 4.0, 10), invariance=sides)
    body = Body.of(animation, animation, points, parameters, moves_root=True)
    goals = places_of(animation, body, frames) + rng.normal(size=(3, 2, 3)) * [[[1e-3]], [[0.02]], [[0.1]]]
    weights = np.array([[1.0, 0.0], [0.3, 0.8], [1.0, 1.0]])
    together = body.reached(frames, goals, weights)
    for k in range(len(frames)):
        one = slice(k, k + 1)
        for alone, each in zip(body.reached(frames[one], goals[one], weights[one]), together, strict=True):
            np.testing.assert_array_equal(alone[0], each[k])


def test_a_right_invariant_metric_weighs_turns_in_the_frame_of_the_parent():
    # a joint with a metric that is right-invariant turns as one with that metric, seen in its own frame, would
    animation = walk(seconds=1.0, rate=10.0)[0]
    frames, rng = np.array([4]), np.random.default_rng(2)
    alpha, beta, axes = rng.uniform(0.5, 4.0, 10), rng.uniform(0.5, 4.0, 10), rng.normal(size=(10, 3))
    right = MetricParameters(alpha, beta, axes, invariance="right")
    turn = quat.to_matrix(animation.rotations[4])
    left = MetricParameters.from_matrices(turn.swapaxes(-1, -2) @ right.matrices @ turn)
    found = []
    for parameters in (right, left):
        body = Body.of(animation, animation, np.array([3, 7]), parameters, moves_root=True)
        goals = places_of(animation, body, frames) + [[[0.01, 0.02, 0.0], [0.0, 0.01, -0.02]]]
        found.append(body.reached(frames, goals, np.ones((1, 2))))
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-9)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-9)
