"""Print the tables of docs/geomstats.rst: what works on poses, in what time, and in what time by Geomstats alone."""

import logging
import signal
import sys
import time
import warnings
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import geomstats.learning as learning
import numpy as np
from geomstats.geometry.invariant_metric import InvariantMetric
from geomstats.geometry.nfold_manifold import NFoldManifold
from geomstats.geometry.special_orthogonal import SpecialOrthogonal

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "geomstats_anim"))

from geomstats_cases import (  # noqa: E402
    CALLS,
    ESTIMATORS,
    HERE,
    METHODS,
    MODELS,
    SPACE_METHODS,
    estimator_method,
    problem,
)

N_BONES, N_POSES = 24, 30
PATIENCE = 3
"""Seconds of processor after which stock Geomstats is stopped."""

ENOUGH = 0.1
"""Seconds after which calls are no longer repeated."""

STOCK_MODULES = {
    "TangentPCA": "pca",
    "ToTangentSpace": "preprocessing",
    "KNearestNeighborsClassifier": "knn",
    "KernelDensityEstimationClassifier": "kernel_density_estimation_classifier",
    "AgglomerativeHierarchicalClustering": "agglomerative_hierarchical_clustering",
    "WrappedGaussianProcess": "wrapped_gaussian_process",
    "GeodesicRegression": "geodesic_regression",
}


class TooLong(Exception):
    """Raised when the patience is over."""


@contextmanager
def limited(seconds):
    """Raise TooLong after some seconds of processor."""

    def stop(*_):
        raise TooLong

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def measured(call):
    """Return the mean processor time of a call in words, or why it has none."""
    try:
        with limited(PATIENCE):
            call()  # once more than is measured: what is imported or cached on the first call does not count
            n_calls, start = 0, time.process_time()
            while n_calls == 0 or time.process_time() - start < ENOUGH:
                call()
                n_calls += 1
            mean = (time.process_time() - start) / n_calls
    except TooLong:
        return f"> {PATIENCE} s"
    except Exception:
        return "fails"
    return f"{1e3 * mean:.2g} ms" if mean < 0.0995 else f"{1e3 * mean:.0f} ms" if mean < 0.9995 else f"{mean:.1f} s"


def stock_problem(ours):
    """Return the same poses in Geomstats' own space."""
    so3 = SpecialOrthogonal(3, equip=False)
    so3.equip_with_metric(InvariantMetric, metric_mat_at_identity=np.diag([1.0, 2.0, 0.5]), left=True)
    return replace(ours, space=NFoldManifold(so3, N_BONES))


def stock_class(name):
    """Return the class of Geomstats that this package has one of the same name for, if it has."""
    if name not in STOCK_MODULES:
        return None
    return getattr(__import__(f"{learning.__name__}.{STOCK_MODULES[name]}", fromlist=[name]), name)


def print_estimators(ours, stock):
    """Print the table of estimators."""
    print("estimator | on poses | time | stock")
    for name, run in ESTIMATORS.items():
        here = HERE.get(name)
        mine = measured(lambda run=run, here=here: run(ours, here))
        other = measured(lambda run=run, name=name: run(stock, stock_class(name)))
        print(f"{name} | {'no' if mine == 'fails' else 'here' if here else 'works'} | {mine} | {other}", flush=True)


def print_estimator_methods(ours):
    """Print the table of the methods of estimators, fit included."""
    print("\nmethod, after a fit | on poses | time of both")
    for name in MODELS:
        promised = stock_class(name) or type(MODELS[name](ours, None)[0])
        for method in CALLS:
            if hasattr(promised, method):
                run = estimator_method(name, method)
                mine = measured(lambda run=run, name=name: run(ours, HERE.get(name)))
                word = "no" if mine == "fails" else "here" if name in HERE else "works"
                print(f"{name}.{method} | {word} | {mine}", flush=True)


def print_methods(title, methods, ours, stock, prefix=""):
    """Print a table of methods of the metric or of the space."""
    print(f"\n{title} | on poses | time | stock")
    for name, run in methods.items():
        mine = measured(lambda run=run: run(ours))
        other = measured(lambda run=run: run(stock))
        print(f"``{prefix}{name}`` | {'no' if mine == 'fails' else 'works'} | {mine} | {other}", flush=True)


def main():
    """Print the tables that are named, or all."""
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    ours = problem(N_BONES, N_POSES)
    stock = stock_problem(ours)
    tables = {
        "estimators": lambda: print_estimators(ours, stock),
        "estimator-methods": lambda: print_estimator_methods(ours),
        "metric": lambda: print_methods("method", METHODS, ours, stock),
        "space": lambda: print_methods("method", SPACE_METHODS, ours, stock, "space."),
    }
    for name in sys.argv[1:] or tables:
        tables[name]()


if __name__ == "__main__":
    main()
