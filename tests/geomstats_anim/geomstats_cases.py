"""Every estimator of `geomstats.learning`, and every method of its metrics, tried on poses."""

import random
from dataclasses import dataclass
from typing import Any

import numpy as np
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.learning.aac import AAC
from geomstats.learning.expectation_maximization import RiemannianEM
from geomstats.learning.exponential_barycenter import ExponentialBarycenter
from geomstats.learning.frechet_mean import FrechetMean
from geomstats.learning.geometric_median import GeometricMedian
from geomstats.learning.incremental_frechet_mean import IncrementalFrechetMean
from geomstats.learning.kmeans import RiemannianKMeans
from geomstats.learning.kmedoids import RiemannianKMedoids
from geomstats.learning.mdm import RiemannianMinimumDistanceToMean
from geomstats.learning.online_kmeans import OnlineKMeans
from geomstats.learning.pca import ExactPGA
from geomstats.learning.riemannian_mean_shift import RiemannianMeanShift

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric
from geomstats_anim.riemannian import estimators, regression


@dataclass(frozen=True)
class Problem:
    """Poses around two centers."""

    space: Any
    points: Any
    labels: Any
    times: Any
    tangent_vecs: Any
    """Three tangent vectors at the first point."""

    @property
    def base(self):
        return self.points[0]


def problem(n_bones=3, n_poses=12):
    rng = np.random.default_rng(0)
    np.random.seed(0)
    random.seed(0)
    parameters = MetricParameters(np.full(n_bones, 2.0), np.full(n_bones, 0.5))
    space = PoseSpace(n_bones, equip=False).equip_with_metric(PoseMetric, parameters=parameters)
    return _around_two_centers(rng, space, n_poses)


def _around_two_centers(rng, space, n_points):
    labels = np.arange(n_points) % 2
    first = space.random_point()
    second = space.metric.exp(space.metric.from_coordinates(np.full(space.dim, 0.3), first), first)
    centers = np.stack([first, second])[labels]
    noise = space.metric.from_coordinates(0.05 * rng.normal(size=(n_points, space.dim)), centers)
    points = space.metric.exp(noise, centers)
    vectors = space.metric.from_coordinates(0.1 * rng.normal(size=(3, space.dim)), points[0])
    return Problem(space, points, labels, np.linspace(0.0, 1.0, n_points), vectors)


def rotations_problem(n_points=12):
    """Rotations around two centers, with a full matrix that is right-invariant."""
    rng = np.random.default_rng(0)
    np.random.seed(0)
    random.seed(0)
    matrix = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])
    space = SpecialOrthogonal(3, equip=False)
    space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=matrix, left=False)
    return _around_two_centers(rng, space, n_points)


def _prior(p):
    return lambda x: np.broadcast_to(p.base, (len(x), *p.space.shape))


HERE = {
    "TangentPCA": estimators.TangentPCA,
    "ToTangentSpace": estimators.ToTangentSpace,
    "KNearestNeighborsClassifier": estimators.KNearestNeighborsClassifier,
    "KernelDensityEstimationClassifier": estimators.KernelDensityEstimationClassifier,
    "AgglomerativeHierarchicalClustering": estimators.AgglomerativeHierarchicalClustering,
    "WrappedGaussianProcess": estimators.WrappedGaussianProcess,
    "GeodesicRegression": regression.GeodesicRegression,
}
"""Estimators that this package has under the names of Geomstats."""

ESTIMATORS = {
    "FrechetMean": lambda p, _: FrechetMean(p.space).fit(p.points).estimate_,
    "FrechetMean, adaptive": lambda p, _: FrechetMean(p.space, method="adaptive").fit(p.points).estimate_,
    "FrechetMean, batch": lambda p, _: FrechetMean(p.space, method="batch").fit(p.points[:, None]).estimate_[0],
    "IncrementalFrechetMean": lambda p, _: IncrementalFrechetMean(p.space).fit(p.points).estimate_,
    "ExponentialBarycenter": lambda p, _: ExponentialBarycenter(p.space).fit(p.points).estimate_,
    "GeometricMedian": lambda p, _: GeometricMedian(p.space).fit(p.points).estimate_,
    "TangentPCA": lambda p, e: e(p.space, n_components=2).fit(p.points).transform(p.points),
    "ToTangentSpace": lambda p, e: e(p.space).fit(p.points).transform(p.points),
    "RiemannianKMeans": lambda p, _: RiemannianKMeans(p.space, 2, init="kmeans++").fit(p.points).labels_,
    "RiemannianKMedoids": lambda p, _: RiemannianKMedoids(p.space, 2).fit(p.points).labels_,
    "OnlineKMeans": lambda p, _: OnlineKMeans(p.space, 2, max_iter=20).fit(p.points).labels_,
    "RiemannianMeanShift": lambda p, _: RiemannianMeanShift(p.space, 1.0).fit(p.points).predict(p.points),
    "AgglomerativeHierarchicalClustering": lambda p, e: e(p.space).fit(p.points).labels_,
    "KNearestNeighborsClassifier": lambda p, e: e(p.space).fit(p.points, p.labels).predict(p.points),
    "KernelDensityEstimationClassifier": lambda p, e: e(p.space).fit(p.points, p.labels).predict(p.points),
    "RiemannianMinimumDistanceToMean": lambda p, _: (
        RiemannianMinimumDistanceToMean(p.space).fit(p.points, p.labels).predict(p.points)
    ),
    "GeodesicRegression": lambda p, e: e(p.space).fit(p.times, p.points).predict(p.times),
    "WrappedGaussianProcess": lambda p, e: (
        e(p.space, prior=_prior(p)).set(optimizer=None).fit(p.times[:, None], p.points).predict(p.times[:, None])
    ),
    "RiemannianEM": lambda p, _: RiemannianEM(p.space, n_gaussians=2).fit(p.points),
    "ExactPGA": lambda p, _: ExactPGA(p.space),
    "AAC": lambda p, _: AAC(p.space, estimate="frechet_mean").fit(p.points),
}
"""Action of a row of the table; it takes a problem, and the class where it is one of `HERE`."""


MODELS = {
    "FrechetMean": lambda p, _: (FrechetMean(p.space), p.points, None),
    "IncrementalFrechetMean": lambda p, _: (IncrementalFrechetMean(p.space), p.points, None),
    "ExponentialBarycenter": lambda p, _: (ExponentialBarycenter(p.space), p.points, None),
    "GeometricMedian": lambda p, _: (GeometricMedian(p.space), p.points, None),
    "TangentPCA": lambda p, e: (e(p.space, n_components=2), p.points, None),
    "ToTangentSpace": lambda p, e: (e(p.space), p.points, None),
    "RiemannianKMeans": lambda p, _: (RiemannianKMeans(p.space, 2, init="kmeans++"), p.points, None),
    "RiemannianKMedoids": lambda p, _: (RiemannianKMedoids(p.space, 2), p.points, None),
    "OnlineKMeans": lambda p, _: (OnlineKMeans(p.space, 2, max_iter=20), p.points, None),
    "RiemannianMeanShift": lambda p, _: (RiemannianMeanShift(p.space, 1.0), p.points, None),
    "AgglomerativeHierarchicalClustering": lambda p, e: (e(p.space), p.points, None),
    "KNearestNeighborsClassifier": lambda p, e: (e(p.space), p.points, p.labels),
    "KernelDensityEstimationClassifier": lambda p, e: (e(p.space), p.points, p.labels),
    "RiemannianMinimumDistanceToMean": lambda p, _: (RiemannianMinimumDistanceToMean(p.space), p.points, p.labels),
    "GeodesicRegression": lambda p, e: (e(p.space), p.times, p.points),
    "WrappedGaussianProcess": lambda p, e: (
        e(p.space, prior=_prior(p)).set(optimizer=None),
        p.times[:, None],
        p.points,
    ),
}
"""An estimator, and what it is fitted to."""

CALLS = {
    "fit": lambda model, x: model,
    "fit_predict": lambda model, x: model.fit_predict(x),
    "fit_transform": lambda model, x, y: model.fit_transform(x) if y is None else model.fit_transform(x, y),
    "transform": lambda model, x: model.transform(x),
    "inverse_transform": lambda model, x: model.inverse_transform(model.transform(x)),
    "predict": lambda model, x: model.predict(x),
    "predict_proba": lambda model, x: model.predict_proba(x),
    "score": lambda model, x, y: model.score(x, y),
    "sample_y": lambda model, x: model.sample_y(x, n_samples=2),
    "kneighbors": lambda model, x: model.kneighbors(x)[0],
    "kneighbors_graph": lambda model, x: model.kneighbors_graph(x).toarray(),
    "radius_neighbors": lambda model, x: model.radius_neighbors(x)[0],
    "radius_neighbors_graph": lambda model, x: model.radius_neighbors_graph(x).toarray(),
}
"""Return what a method is called with, after the fit."""


def estimator_method(name, method):
    """Return a function of a problem, and the class where it is one of `HERE`, that calls a method."""

    def run(p, e):
        model, x, y = MODELS[name](p, e)
        fitted = model.fit(x) if y is None else model.fit(x, y)
        values = CALLS[method](fitted, x, y) if method in ("score", "fit_transform") else CALLS[method](fitted, x)
        return 0.0 if values is fitted else values

    return run


SPACE_METHODS = {
    "belongs": lambda p: p.space.belongs(p.points),
    "is_tangent": lambda p: p.space.is_tangent(p.tangent_vecs, p.base),
    "to_tangent": lambda p: p.space.to_tangent(p.points, p.base),
    "projection": lambda p: p.space.projection(p.points + 0.01),
    "regularize": lambda p: p.space.regularize(p.points),
    "random_point": lambda p: p.space.random_point(3),
    "random_tangent_vec": lambda p: p.space.random_tangent_vec(p.base, 3),
    "identity": lambda p: p.space.identity,
    "compose": lambda p: p.space.compose(p.points, p.base),
    "inverse": lambda p: p.space.inverse(p.points),
    "exp": lambda p: p.space.exp(p.tangent_vecs, p.base),
    "log": lambda p: p.space.log(p.points, p.base),
    "lie_bracket": lambda p: p.space.lie_bracket(p.tangent_vecs[0], p.tangent_vecs[1], p.base),
    "tangent_translation_map": lambda p: p.space.tangent_translation_map(p.base, inverse=True)(p.tangent_vecs),
}
"""Action of a row of the table of the group with a problem."""


def _at(name, *vectors):
    return lambda p: getattr(p.space.metric, name)(*(p.tangent_vecs[i] for i in vectors), base_point=p.base)


METHODS = {
    "inner_product": _at("inner_product", 0, 1),
    "squared_norm": lambda p: p.space.metric.squared_norm(p.tangent_vecs, p.base),
    "norm": lambda p: p.space.metric.norm(p.tangent_vecs, p.base),
    "normalize": lambda p: p.space.metric.normalize(p.tangent_vecs, p.base),
    "normal_basis": lambda p: p.space.metric.normal_basis(p.space.random_tangent_vec(p.base, p.space.dim), p.base),
    "random_unit_tangent_vec": lambda p: p.space.metric.random_unit_tangent_vec(p.base, 4),
    "exp": lambda p: p.space.metric.exp(p.tangent_vecs, p.base),
    "log": lambda p: p.space.metric.log(p.points, p.base),
    "geodesic": lambda p: p.space.metric.geodesic(p.base, end_point=p.points)([0.0, 0.5, 1.0]),
    "dist": lambda p: p.space.metric.dist(p.base, p.points),
    "squared_dist": lambda p: p.space.metric.squared_dist(p.base, p.points),
    "dist_broadcast": lambda p: p.space.metric.dist_broadcast(p.points[:3], p.points),
    "dist_pairwise": lambda p: p.space.metric.dist_pairwise(p.points),
    "diameter": lambda p: p.space.metric.diameter(p.points),
    "closest_neighbor_index": lambda p: p.space.metric.closest_neighbor_index(p.base, p.points),
    "parallel_transport": lambda p: p.space.metric.parallel_transport(
        p.tangent_vecs[0], p.base, direction=p.tangent_vecs[1]
    ),
    "ladder_parallel_transport": lambda p: p.space.metric.ladder_parallel_transport(
        p.tangent_vecs[0], p.base, p.tangent_vecs[1]
    )["transported_tangent_vec"],
    "curvature": _at("curvature", 0, 1, 2),
    "curvature_derivative": _at("curvature_derivative", 0, 1, 2, 0),
    "sectional_curvature": _at("sectional_curvature", 0, 1),
    "directional_curvature": _at("directional_curvature", 0, 1),
    "directional_curvature_derivative": _at("directional_curvature_derivative", 0, 1),
    "ricci_tensor": _at("ricci_tensor"),
    "scalar_curvature": _at("scalar_curvature"),
    "injectivity_radius": _at("injectivity_radius"),
    "metric_matrix": _at("metric_matrix"),
    "cometric_matrix": _at("cometric_matrix"),
    "christoffels": _at("christoffels"),
    "inner_coproduct": lambda p: p.space.metric.inner_coproduct(np.ones(p.space.dim), np.ones(p.space.dim), p.base),
    "hamiltonian": lambda p: p.space.metric.hamiltonian((p.base, np.ones(p.space.dim))),
    "geodesic_equation": lambda p: p.space.metric.geodesic_equation(np.stack([p.base, p.tangent_vecs[0]])),
    "riemann_tensor": _at("riemann_tensor"),
    "covariant_riemann_tensor": _at("covariant_riemann_tensor"),
    "inner_product_derivative_matrix": _at("inner_product_derivative_matrix"),
}
"""Action of a row of the table with a problem."""
