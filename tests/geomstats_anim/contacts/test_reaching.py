"""Laws of the smallest correction."""

import numpy as np
from scipy.optimize import minimize
from walker import walk

from geomstats_anim import MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.contacts.reaching import Body
from geomstats_anim.markers import joint_matrices, place_some


def test_the_correction_is_the_smallest_to_second_order():
    animation = walk(seconds=1.0, rate=10.0)[0]
    rng = np.random.default_rng(0)
    parameters = MetricParameters(rng.uniform(0.5, 4.0, 10), rng.uniform(0.5, 4.0, 10), rng.normal(size=(10, 3)))
    body = Body.of(animation, animation, np.array([3]), parameters, moves_root=False)
    part, frames = body.dense, np.array([4])
    goal = joint_matrices(part.at_frames(frames))[..., 3][:, body.points] + [[[0.004, 0.006, -0.003]]]
    rotations, translations = body.reached(frames, goal, np.ones((1, 1)))
    base = part.rotations[frames]
    found = quat.difference(base, rotations)[0]
    costs = body.units @ body.units.swapaxes(-1, -2)  # all of this chain turn, so all are free

    def cost(vector):
        turns = vector.reshape(-1, 3)
        return np.einsum("ji,jik,jk->", turns, np.linalg.inv(costs), turns)

    def miss(vector):
        turned = quat.multiply(base, quat.exp(vector.reshape(1, -1, 3)))
        matrices = joint_matrices(part.at_frames(frames))
        place_some(part.at_frames(frames), turned, np.array(translations), np.arange(turned.shape[1]), matrices)
        return 1e3 * (matrices[0, body.points[0], :, 3] - goal[0, 0])

    best = minimize(cost, np.zeros(found.size), constraints={"type": "eq", "fun": miss}, method="SLSQP", tol=1e-14)
    assert best.success
    assert np.abs(miss(found.ravel())).max() < 1e-2  # micrometres
    assert cost(found.ravel()) < 1.01 * best.fun


def test_a_point_that_is_free_changes_nothing():
    animation = walk(seconds=1.0, rate=10.0)[0]
    body = Body.of(animation, animation, np.array([3, 7]), MetricParameters.identity(10), moves_root=True)
    frames = np.array([3, 4, 5])
    places = joint_matrices(body.dense.at_frames(frames))[..., 3][:, body.points]
    rotations, translations = body.reached(frames, places + 0.05, np.zeros((3, 2)))
    assert quat.distance(rotations, body.dense.rotations[frames]).max() < 1e-6
    np.testing.assert_allclose(translations, body.dense.translations[frames], atol=1e-8)


def test_the_root_moves_where_a_leg_is_too_short():
    animation = walk(seconds=1.0, rate=10.0)[0]
    body = Body.of(animation, animation, np.array([3]), MetricParameters.identity(10), moves_root=True)
    frames = np.array([4])
    place = joint_matrices(body.dense.at_frames(frames))[..., 3][:, body.points]
    moves = []
    for way in ([0.01, 0.0, 0.0], [0.0, -0.25, 0.0]):  # the leg is 0.9 metres long, and bent a little
        _, translations = body.reached(frames, place + way, np.ones((1, 1)))
        moves.append(np.linalg.norm(translations[0, body.root] - body.dense.translations[4, body.root]))
    assert moves[0] < 0.2 * 0.01
    assert moves[1] > 0.1
