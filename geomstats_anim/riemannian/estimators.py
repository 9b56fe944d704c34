"""Estimators of `geomstats.learning` that fail on poses, with the same names and arguments.

Geomstats 2.8 takes points for vectors or single matrices there, and scikit-learn takes them for rows of numbers.
These work for the metrics of this package; the other estimators of Geomstats work as they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.learning.frechet_mean import FrechetMean
from geomstats.learning.wrapped_gaussian_process import WrappedGaussianProcess as _WrappedGaussianProcess
from sklearn.base import BaseEstimator, ClassifierMixin, TransformerMixin
from sklearn.cluster import AgglomerativeClustering
from sklearn.decomposition import PCA
from sklearn.neighbors import KNeighborsClassifier, RadiusNeighborsClassifier

_MEAN_TOLERANCE = 1e-20
"""Square of the mean's gradient at which its search ends."""


def mean_estimator(space: Any) -> Any:
    """Make the Frechet mean of a space with a search that ends at rounding, and not at Geomstats' 1e-4.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped.

    Returns
    -------
    estimator : FrechetMean
    """
    return FrechetMean(space).set(epsilon=_MEAN_TOLERANCE, max_iter=200)


class ToTangentSpace(BaseEstimator, TransformerMixin):
    """Lift poses to the tangent space at their mean, as coordinates in an orthonormal frame.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.

    Attributes
    ----------
    base_point_ : array-like, shape=[*space.shape]
    """

    def __init__(self, space: Any) -> None:
        self.space = space
        self.mean_estimator = mean_estimator(space)
        self.base_point_: Any = None

    def fit(self, X: Any, y: Any = None, weights: Any = None, base_point: Any = None) -> ToTangentSpace:
        """Find the base point.

        Parameters
        ----------
        X : array-like, shape=[n_samples, *space.shape]
        y : None
            Ignored.
        weights : array-like, shape=[n_samples]
            Optional, default: None, all the same.
        base_point : array-like, shape=[*space.shape]
            Optional, default: the Frechet mean of X.

        Returns
        -------
        self : ToTangentSpace
        """
        self.base_point_ = self.mean_estimator.fit(X, y, weights).estimate_ if base_point is None else base_point
        return self

    def transform(self, X: Any) -> Any:
        """Return the coordinates of the logarithms, shape=[n_samples, dim], of points."""
        return self.space.metric.coordinates(self.space.metric.log(X, self.base_point_), self.base_point_)

    def inverse_transform(self, X: Any) -> Any:
        """Return the points, shape=[n_samples, *space.shape], of coordinates."""
        return self.space.metric.exp(self.space.metric.from_coordinates(X, self.base_point_), self.base_point_)


class TangentPCA(BaseEstimator, TransformerMixin):
    """Principal component analysis in the tangent space at the mean, with the inner product of the metric.

    Geomstats takes the Frobenius product of matrices instead, whatever the metric.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.
    n_components : int or float or str
        As in `sklearn.decomposition.PCA`.
        Optional, default: None, all.
    whiten : bool
        Optional, default: False.

    Attributes
    ----------
    base_point_ : array-like, shape=[*space.shape]
    components_ : array-like, shape=[n_components, *space.shape]
        Orthonormal tangent vectors at the base point.
    explained_variance_ : array-like, shape=[n_components]
        In squared lengths of the metric.
    explained_variance_ratio_ : array-like, shape=[n_components]
    """

    def __init__(self, space: Any, n_components: Any = None, whiten: bool = False) -> None:
        self.space = space
        self.n_components, self.whiten = n_components, whiten

    def fit(self, X: Any, y: Any = None, base_point: Any = None) -> TangentPCA:
        """Find the principal components.

        Parameters
        ----------
        X : array-like, shape=[n_samples, *space.shape]
        y : None
            Ignored.
        base_point : array-like, shape=[*space.shape]
            Optional, default: the Frechet mean of X.

        Returns
        -------
        self : TangentPCA
        """
        self._lift = ToTangentSpace(self.space).fit(X, base_point=base_point)
        coordinates = gs.to_numpy(self._lift.transform(X))
        self._pca = PCA(self.n_components, whiten=self.whiten, svd_solver="full").fit(coordinates)
        self.base_point_, self.n_components_ = self._lift.base_point_, self._pca.n_components_
        components = gs.from_numpy(self._pca.components_)
        self.components_ = self.space.metric.from_coordinates(components, self.base_point_)
        self.explained_variance_ = gs.from_numpy(self._pca.explained_variance_)
        self.explained_variance_ratio_ = gs.from_numpy(self._pca.explained_variance_ratio_)
        return self

    def transform(self, X: Any) -> Any:
        """Return the scores, shape=[n_samples, n_components], of points."""
        return gs.from_numpy(self._pca.transform(gs.to_numpy(self._lift.transform(X))))

    def inverse_transform(self, X: Any) -> Any:
        """Return the points, shape=[n_samples, *space.shape], of scores."""
        return self._lift.inverse_transform(gs.from_numpy(self._pca.inverse_transform(gs.to_numpy(X))))


class _OnDistances(ClassifierMixin, BaseEstimator):
    """A classifier of scikit-learn that is given distances to the training points instead of points."""

    space: Any

    def _classifier(self) -> Any:
        raise NotImplementedError

    def fit(self, X: Any, y: Any) -> Any:
        """Keep points, shape=[n_samples, *space.shape], and their labels, shape=[n_samples]; return itself."""
        self._points = X
        self._fitted = self._classifier().fit(gs.to_numpy(self.space.metric.dist_pairwise(X)), gs.to_numpy(y))
        self.classes_ = self._fitted.classes_
        return self

    def predict(self, X: Any) -> Any:
        """Return the labels, shape=[n_samples], of points, shape=[n_samples, *space.shape]."""
        return self._fitted.predict(self._distances(X))

    def predict_proba(self, X: Any) -> Any:
        """Return the shares of the classes, shape=[n_samples, n_classes], at points."""
        return self._fitted.predict_proba(self._distances(X))

    def _distances(self, X: Any) -> np.ndarray:
        return np.asarray(gs.to_numpy(self.space.metric.dist(X[:, None], self._points[None])))


class KNearestNeighborsClassifier(_OnDistances):
    """Vote of the nearest neighbors.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.
    n_neighbors : int
        Optional, default: 5.
    weights : str or callable
        "uniform", "distance", or a function of arrays of distances, as in scikit-learn.
        Optional, default: "uniform".
    """

    def __init__(self, space: Any, n_neighbors: int = 5, weights: Any = "uniform") -> None:
        self.space = space
        self.n_neighbors, self.weights = n_neighbors, weights

    def kneighbors(self, X: Any, n_neighbors: int | None = None, return_distance: bool = True) -> Any:
        """Return the distances and indices, shape=[n_samples, n_neighbors] each, of the nearest training points.

        Parameters
        ----------
        X : array-like, shape=[n_samples, *space.shape]
        n_neighbors : int
            Optional, default: that of the classifier.
        return_distance : bool
            Whether to return the distances, and not the indices alone.
            Optional, default: True.
        """
        return self._fitted.kneighbors(self._distances(X), n_neighbors, return_distance)

    def kneighbors_graph(self, X: Any, n_neighbors: int | None = None, mode: str = "connectivity") -> Any:
        """Return the nearest training points as a sparse matrix of ones, or of distances; see `kneighbors`."""
        return self._fitted.kneighbors_graph(self._distances(X), n_neighbors, mode)

    def _classifier(self) -> Any:
        return KNeighborsClassifier(self.n_neighbors, weights=self.weights, metric="precomputed", algorithm="brute")


class KernelDensityEstimationClassifier(_OnDistances):
    """The class whose points are the densest, by a radial kernel.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.
    radius : float
        Optional, default: infinite.
    kernel : str or callable
        "distance", "uniform", or a function of `distance` and `bandwidth`, as in
        `geomstats.learning.radial_kernel_functions`.
        Optional, default: "distance".
    bandwidth : float
        Optional, default: 1.
    outlier_label : object
        Label of points without neighbors within the radius.
        Optional, default: None, they raise an error.
    """

    def __init__(
        self,
        space: Any,
        radius: float = math.inf,
        kernel: str | Callable[..., Any] = "distance",
        bandwidth: float = 1.0,
        outlier_label: Any = None,
    ) -> None:
        self.space = space
        self.radius, self.kernel, self.bandwidth, self.outlier_label = radius, kernel, bandwidth, outlier_label

    def radius_neighbors(self, X: Any, radius: float | None = None, return_distance: bool = True) -> Any:
        """Return the distances and indices of the training points within a radius, an array for each point.

        Parameters
        ----------
        X : array-like, shape=[n_samples, *space.shape]
        radius : float
            Optional, default: that of the classifier.
        return_distance : bool
            Whether to return the distances, and not the indices alone.
            Optional, default: True.
        """
        return self._fitted.radius_neighbors(self._distances(X), radius, return_distance)

    def radius_neighbors_graph(self, X: Any, radius: float | None = None, mode: str = "connectivity") -> Any:
        """Return the training points within a radius as a sparse matrix of ones, or of distances."""
        return self._fitted.radius_neighbors_graph(self._distances(X), radius, mode)

    def _classifier(self) -> Any:
        return RadiusNeighborsClassifier(
            self.radius,
            weights=self.kernel if isinstance(self.kernel, str) else self._weigh,
            metric="precomputed",
            algorithm="brute",
            outlier_label=self.outlier_label,
        )

    def _weigh(self, distances: Any) -> np.ndarray:
        """Weigh arrays of distances; scikit-learn gives one array for each point, of any length."""
        assert callable(self.kernel)
        bandwidth = gs.array(self.bandwidth)
        weights = [
            gs.to_numpy(self.kernel(distance=gs.from_numpy(np.asarray(row, dtype=float)), bandwidth=bandwidth))
            for row in distances
        ]
        same = len({len(row) for row in weights}) < 2
        result = np.empty(len(weights), dtype=object) if not same else np.array(weights)
        if not same:
            result[:] = weights
        return result


class AgglomerativeHierarchicalClustering(AgglomerativeClustering):
    """Clusters that are merged by their distances; parameters and attributes are those of scikit-learn.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.
    n_clusters : int
        None where there is a distance_threshold.
        Optional, default: 2.
    linkage : str
        "average", "complete" or "single"; "ward" needs a vector space.
        Optional, default: "average".
    distance_threshold : float
        Optional, default: None.
    """

    def __init__(
        self,
        space: Any,
        n_clusters: int | None = 2,
        linkage: str = "average",
        distance_threshold: float | None = None,
    ) -> None:
        self.space = space
        super().__init__(n_clusters, metric="precomputed", linkage=linkage, distance_threshold=distance_threshold)

    def fit(self, X: Any, y: Any = None) -> AgglomerativeHierarchicalClustering:
        """Cluster points, shape=[n_samples, *space.shape]; y is ignored; return itself."""
        super().fit(gs.to_numpy(self.space.metric.dist_pairwise(X)))
        return self


class WrappedGaussianProcess(_WrappedGaussianProcess):
    """Geomstats' own, with a score that measures distances."""

    def score(self, X: Any, y: Any, sample_weight: Any = None) -> float:
        """Return the share of the variance of poses, shape=[n_samples, *space.shape], that is predicted.

        Parameters
        ----------
        X : array-like, shape=[n_samples, n_features]
        y : array-like, shape=[n_samples, *space.shape]
        sample_weight : array-like, shape=[n_samples]
            Optional, default: None, all the same.

        Returns
        -------
        score : float
            At most 1; 0 for the mean of y.
        """
        return variance_score(self.space, y, self.predict(X), sample_weight)


def variance_score(space: Any, y: Any, predicted: Any, weights: Any = None) -> float:
    """Return 1 minus the squared distances of a prediction by those of the mean, at most 1."""
    share = gs.ones(len(y)) if weights is None else weights
    mean = mean_estimator(space).fit(y, weights=weights).estimate_
    left, whole = (gs.sum(share * space.metric.squared_dist(y, point)) for point in (predicted, mean))
    return float(1.0 - left / whole)
