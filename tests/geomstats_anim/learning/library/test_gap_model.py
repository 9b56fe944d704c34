import numpy as np
from gaits import gait, library
from scipy.spatial.distance import cdist

from geomstats_anim.learning.library.context import contexts_of
from geomstats_anim.learning.library.regression import weights_of


def segments():
    """Return a model, and the surroundings of segments of a clip and of itself once more."""
    keys, shared = gait(100, 81).at_frames(np.arange(0, 81, 8)), library()
    images = np.stack([keys.rotations] * 2)
    return shared.models[0], contexts_of(keys.times, images, shared.parts.trunk, shared.vertical)


def test_kernels_are_those_of_weighted_distances():
    model, contexts = segments()
    features = model.features(contexts, contexts.scales(model.features.parts))
    squares = np.stack([cdist(*pair, "sqeuclidean") for pair in zip(features, model.centres.features, strict=True)])
    for part, kernel in enumerate(model.centres.kernels(features)):
        weights = np.where(np.arange(len(squares)) == part, 1.0, 0.225**2)
        weights[-1] = 1.0
        np.testing.assert_allclose(kernel, np.exp(-np.tensordot(weights, squares, 1)), rtol=1e-10)


def test_predictions_are_those_of_the_regression_to_single_precision():
    model, contexts = segments()
    parts, scales = model.features.parts, contexts.scales(model.features.parts)
    kernels = model.centres.kernels(model.features(contexts, scales))
    expected = np.empty((20, model.n_sines, len(parts.of_joint), 3))
    for p, joints in enumerate(parts.joints):
        of_part = kernels[p] @ weights_of(model.whitened[p], model.centres.factors[p]) * scales[:, p, None]
        expected[:, :, joints] = of_part.reshape(20, model.n_sines, -1, 3)
    assert 0.01 < abs(expected).max()
    np.testing.assert_allclose(model.predict(contexts), expected, atol=2e-5 * abs(expected).max())


def test_images_are_predicted_alike_to_the_last_bit():
    model, contexts = segments()
    first, second = np.split(model.predict(contexts, 2), 2)
    np.testing.assert_array_equal(first, second)


def test_many_segments_are_predicted_as_few_are():
    model, contexts = segments()
    many = model.predict(contexts.at(np.tile(np.arange(20), 20)))
    np.testing.assert_allclose(many, np.tile(model.predict(contexts), (20, 1, 1, 1)), atol=1e-6)
