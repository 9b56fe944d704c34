"""Laws of statistics and learning on poses: the estimators of Geomstats, and those that replace what fails there."""

import random

import numpy as np
import pytest
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.learning.exponential_barycenter import ExponentialBarycenter
from geomstats.learning.frechet_mean import FrechetMean, variance
from geomstats.learning.geometric_median import GeometricMedian
from geomstats.learning.incremental_frechet_mean import IncrementalFrechetMean
from geomstats.learning.kmeans import RiemannianKMeans
from geomstats.learning.kmedoids import RiemannianKMedoids
from geomstats.learning.mdm import RiemannianMinimumDistanceToMean
from geomstats.learning.online_kmeans import OnlineKMeans
from geomstats.learning.radial_kernel_functions import gaussian_radial_kernel
from geomstats.learning.riemannian_mean_shift import RiemannianMeanShift
from sklearn.base import clone
from sklearn.metrics import adjusted_rand_score

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric
from geomstats_anim.riemannian.estimators import (
    AgglomerativeHierarchicalClustering,
    KernelDensityEstimationClassifier,
    KNearestNeighborsClassifier,
    TangentPCA,
    ToTangentSpace,
    WrappedGaussianProcess,
    mean_estimator,
)

FULL = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])


def so3():
    space = SpecialOrthogonal(3, equip=False)
    return space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=FULL, left=False)


def poses(n_bones=3):
    rng = np.random.default_rng(1)
    parameters = MetricParameters(
        np.exp(0.5 * rng.normal(size=n_bones)),
        np.exp(0.5 * rng.normal(size=n_bones)),
        axes=rng.normal(size=(n_bones, 3)),
        invariance=["left", "right"] * (n_bones // 2) + ["left"] * (n_bones % 2),
    )
    return PoseSpace(n_bones, equip=False).equip_with_metric(PoseMetric, parameters=parameters)


@pytest.fixture(params=[so3, poses], ids=["so3", "poses"])
def space(request):
    return request.param()


@pytest.fixture
def rng():
    random.seed(0)
    np.random.seed(0)
    return np.random.default_rng(0)


def around(rng, space, center, n, size):
    """Return points at random, at a distance of about `size` from a center."""
    vectors = size * rng.normal(size=(n, space.dim)) / np.sqrt(space.dim)
    return space.metric.exp(space.metric.from_coordinates(vectors, center), center)


def clusters(rng, space, n=12, size=0.1, gap=1.2):
    """Return points around two centers, and which."""
    first = space.random_point()
    step = rng.normal(size=space.dim)
    second = space.metric.exp(space.metric.from_coordinates(gap * step / np.linalg.norm(step), first), first)
    points = np.concatenate([around(rng, space, center, n, size) for center in (first, second)])
    order = rng.permutation(2 * n)
    return points[order], np.repeat([0, 1], n)[order]


def test_coordinates_are_orthonormal_and_undone(rng, space):
    base = space.random_point(4)
    first, second = (space.random_tangent_vec(base) for _ in range(2))
    metric = space.metric
    a, b = (metric.coordinates(vector, base) for vector in (first, second))
    np.testing.assert_allclose((a * b).sum(axis=-1), metric.inner_product(first, second, base), atol=1e-12)
    np.testing.assert_allclose(metric.from_coordinates(a, base), first, atol=1e-12)
    assert metric.from_coordinates(np.eye(space.dim), base[0]).shape == (space.dim, *space.shape)
    with pytest.raises(ValueError, match="coordinates has shape"):
        metric.from_coordinates(a[..., :-1], base)


def test_pairwise_distances_are_those_of_the_pairs(rng, space):
    points = space.random_point(5)
    dist = space.metric.dist_pairwise(points)
    np.testing.assert_allclose(dist, space.metric.dist(points[:, None], points[None]), atol=1e-9)
    assert space.metric.dist_pairwise(points[:1]).tolist() == [[0.0]]
    assert space.metric.diameter(points) == pytest.approx(dist.max(), rel=1e-12)
    assert space.metric.closest_neighbor_index(points[2], points) == 2


# means


def gradient(space, mean, points, weights=None):
    logs = space.metric.log(points, mean)
    return space.metric.norm(np.average(logs, axis=0, weights=weights), mean)


def test_the_gradient_vanishes_at_the_mean(rng, space):
    points, weights = around(rng, space, space.random_point(), 9, 0.8), rng.uniform(0.2, 1.0, 9)
    mean = mean_estimator(space)
    assert gradient(space, mean.fit(points).estimate_, points) < 1e-8
    assert gradient(space, mean.fit(points, weights=weights).estimate_, points, weights) < 1e-8
    adaptive = FrechetMean(space, method="adaptive").set(epsilon=1e-9, max_iter=200).fit(points).estimate_
    np.testing.assert_allclose(adaptive, mean.fit(points).estimate_, atol=1e-8)
    assert variance(space, points, mean.estimate_) < variance(space, points, points[0])


def test_means_of_a_batch_are_those_of_its_parts(rng, space):
    points = np.stack([around(rng, space, space.random_point(), 6, 0.5) for _ in range(3)], axis=1)
    batch = FrechetMean(space, method="batch").set(epsilon=1e-20, max_iter=200).fit(points).estimate_
    for column in range(3):
        np.testing.assert_allclose(batch[column], mean_estimator(space).fit(points[:, column]).estimate_, atol=1e-9)


def test_other_means_find_the_middle_of_two_poses(rng, space):
    a = space.random_point()
    b = around(rng, space, a, 1, 0.6)[0]
    middle = space.metric.geodesic(a, end_point=b)(0.5)[0]
    both = np.stack([a, b])
    np.testing.assert_allclose(IncrementalFrechetMean(space).fit(both).estimate_, middle, atol=1e-9)
    np.testing.assert_allclose(mean_estimator(space).fit(both).estimate_, middle, atol=1e-9)


def test_the_exponential_barycenter_is_the_group_mean(rng):
    space = PoseSpace(3)
    points = around(rng, space, space.random_point(), 7, 0.6)
    barycenter = ExponentialBarycenter(space).set(epsilon=1e-12).fit(points).estimate_
    # of the bi-invariant metric
    np.testing.assert_allclose(barycenter, mean_estimator(space).fit(points).estimate_, atol=1e-9)


def test_the_median_ignores_an_outlier(rng, space):
    center = space.random_point()
    near = around(rng, space, center, 8, 1e-3)
    points = np.concatenate([near, around(rng, space, center, 1, 1.5)])
    median = GeometricMedian(space, max_iter=500).fit(points).estimate_
    mean = mean_estimator(space).fit(points).estimate_
    assert space.metric.dist(median, center) < 0.02 < 0.05 < space.metric.dist(mean, center)


# components


def test_pca_finds_a_family_of_two_dimensions(rng, space):
    base = space.random_point()
    directions = np.linalg.qr(rng.normal(size=(space.dim, 2)))[0].T
    scores = rng.normal(size=(40, 2)) * [0.5, 0.2]
    scores -= scores.mean(axis=0)
    points = space.metric.exp(space.metric.from_coordinates(scores @ directions, base), base)
    pca = TangentPCA(space, n_components=2).fit(points, base_point=base)
    assert pca.explained_variance_ratio_.sum() == pytest.approx(1.0, abs=1e-12)
    expected = np.linalg.eigvalsh(np.cov(scores.T))[::-1]
    np.testing.assert_allclose(pca.explained_variance_, expected, rtol=1e-9)
    np.testing.assert_allclose(pca.inverse_transform(pca.transform(points)), points, atol=1e-9)
    gram = space.metric.inner_product(pca.components_[:, None], pca.components_[None], base)
    np.testing.assert_allclose(gram, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(pca.fit_transform(points, base_point=base), pca.transform(points), atol=1e-12)


def test_pca_of_all_components_is_undone(rng, space):
    points = around(rng, space, space.random_point(), 20, 0.7)
    pca = TangentPCA(space).fit(points)
    assert gradient(space, pca.base_point_, points) < 1e-8
    np.testing.assert_allclose(pca.inverse_transform(pca.transform(points)), points, atol=1e-9)
    assert len(clone(pca).fit(points).components_) == pca.n_components_ == min(space.dim, 20)


def test_poses_come_back_from_the_tangent_space(rng, space):
    points = around(rng, space, space.random_point(), 10, 0.7)
    lift = ToTangentSpace(space).fit(points)
    vectors = lift.transform(points)
    assert vectors.shape == (10, space.dim)
    np.testing.assert_allclose(vectors.mean(axis=0), 0.0, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), space.metric.dist(lift.base_point_, points), rtol=1e-9)
    np.testing.assert_allclose(lift.inverse_transform(vectors), points, atol=1e-9)


# clusters and classes


@pytest.mark.parametrize(
    "make",
    [
        lambda space: RiemannianKMeans(space, n_clusters=2, init="kmeans++"),
        lambda space: AgglomerativeHierarchicalClustering(space),
        lambda space: AgglomerativeHierarchicalClustering(space, linkage="complete"),
        lambda space: AgglomerativeHierarchicalClustering(space, None, "single", distance_threshold=0.6),
    ],
)
def test_planted_clusters_are_found(rng, space, make):
    points, labels = clusters(rng, space)
    assert adjusted_rand_score(labels, make(space).fit(points).labels_) == 1.0


def test_planted_clusters_are_found_from_good_starts(rng, space):
    # these start from points at random, which may both lie in one cluster
    points, labels = clusters(rng, space)
    medoids = [RiemannianKMedoids(space, n_clusters=2).fit(points) for _ in range(8)]
    assert max(adjusted_rand_score(labels, found.labels_) for found in medoids) == 1.0
    assert max(adjusted_rand_score(labels, found.predict(points)) for found in medoids) == 1.0
    online = [OnlineKMeans(space, n_clusters=2, max_iter=60).fit(points) for _ in range(8)]
    assert max(adjusted_rand_score(labels, found.labels_) for found in online) == 1.0


def test_mean_shift_ends_at_the_means_of_the_clusters(rng, space):
    points, labels = clusters(rng, space)
    shift = RiemannianMeanShift(space, bandwidth=0.6, n_clusters=6).fit(points)
    means = np.stack([FrechetMean(space).fit(points[labels == label]).estimate_ for label in (0, 1)])
    assert space.metric.dist(shift.cluster_centers_[:, None], means[None]).min(axis=1).max() < 0.02


@pytest.mark.parametrize(
    "make",
    [
        lambda space: RiemannianMinimumDistanceToMean(space),
        lambda space: KNearestNeighborsClassifier(space, n_neighbors=3),
        lambda space: KNearestNeighborsClassifier(space, n_neighbors=4, weights="distance"),
        lambda space: KernelDensityEstimationClassifier(space),
        lambda space: KernelDensityEstimationClassifier(space, kernel=gaussian_radial_kernel, bandwidth=0.3),
        lambda space: KernelDensityEstimationClassifier(space, radius=0.7, kernel=gaussian_radial_kernel),
    ],
)
def test_unseen_points_get_the_class_they_lie_in(rng, space, make):
    points, labels = clusters(rng, space, n=16)
    names = np.array(["calm", "wild"])[labels]
    classifier = clone(make(space)).fit(points[:20], names[:20])
    assert classifier.score(points[20:], names[20:]) == 1.0
    shares = classifier.predict_proba(points[20:])
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-9)
    assert (np.asarray(classifier.classes_)[shares.argmax(axis=1)] == names[20:]).all()


def test_the_nearest_neighbor_is_the_nearest(rng, space):
    points, query = space.random_point(9), space.random_point(7)
    found = KNearestNeighborsClassifier(space, n_neighbors=1).fit(points, np.arange(9)).predict(query)
    np.testing.assert_array_equal(found, space.metric.dist(query[:, None], points[None]).argmin(axis=1))


# regression


def test_a_gaussian_process_passes_through_its_data(rng, space):
    times = np.linspace(0.0, 1.0, 12)[:, None]
    base, turn = space.random_point(), rng.normal(size=space.dim) / np.sqrt(space.dim)
    wave = np.sin(1.5 * times) * turn
    points = space.metric.exp(space.metric.from_coordinates(wave, base), base)
    process = WrappedGaussianProcess(space, prior=lambda x: np.broadcast_to(base, (len(x), *space.shape)))
    process.set(optimizer=None).fit(times, points)
    np.testing.assert_allclose(process.predict(times), points, atol=1e-4)
    assert process.score(times, points) == pytest.approx(1.0, abs=1e-6)
    assert process.score(times, points[::-1]) < 0.0
    assert process.sample_y(times, n_samples=2).shape == (12, *space.shape, 2)
