"""Search by tree-structured Parzen estimators (HyperOpt): over all joints at once as the papers do, or joint by joint.

Kushner, Modi, Miolane, "Learning Riemannian metrics for interpolating animations", appendix B. Joint by joint is the
right shape: the rotation error is a sum over joints, and the location errors below two joints of one depth have nothing
in common, so one evaluation serves one suggestion of every joint of a depth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from geomstats_anim.learning.descent import BOUND
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.learning.settings import check_words
from geomstats_anim.learning.tune.ray_runtime import require
from geomstats_anim.learning.tune.settings import JOINT_WINDOW, TuneSettings
from geomstats_anim.names import INVARIANCES, JOINT_TRIALS
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array

STARTUP = 20
"""Random points before the first that HyperOpt derives from the others."""

ZOOM = 0.25
"""Share of the bounds that the last search of a joint is confined to, around what the first has found."""

_AXES_BOUND = np.pi / 2.0  # further turns only exchange or reverse axes, and alpha and beta do that too

Point = dict[str, Any]
"""One value per label: log_alpha_B, log_beta_B, axis_x_B, axis_y_B, axis_z_B a number, side_B or side a word; for
a spline bend_B and path_bend_B, by how much the tensions are above 1."""


class Convergence:
    """No improvement over a window of trials."""

    def __init__(self, window: int, threshold: float) -> None:
        self._window, self._threshold = window, threshold
        self._level, self._since = np.inf, 0

    def reached(self, value: float) -> bool:
        """Take the value of one more trial."""
        # small improvements do not move the level, but they add up
        if value < self._level * (1.0 - self._threshold):
            self._level, self._since = value, 0
        else:
            self._since += 1
        return 0 < self._window <= self._since


@dataclass(frozen=True)
class Space:
    """The metrics that are searched, as HyperOpt sees them.

    Parameters
    ----------
    joints : sequence of int
        Joints that are searched.
    family, invariance, scheme : str
        As in `search_gradient`.
    around : dict
        Point to stay near, within a share of the bounds.
        Optional, default: None, the whole space.
    """

    joints: Sequence[int]
    family: str
    invariance: str
    scheme: str = "geodesic"
    around: Point | None = None

    def __post_init__(self) -> None:
        """Check the words."""
        check_words(self.family, self.invariance)

    @property
    def identity(self) -> Point:
        """Return where every search starts, so that it never ends worse than the scheme without learning."""
        return {label: 0.0 for label in self._bounds()} | {label: INVARIANCES[0] for label in self._sides()}

    def expression(self) -> dict[str, Any]:
        """Write as HyperOpt's expression."""
        hp = require("hyperopt").hp
        numbers = {}
        for label, bound in self._bounds().items():
            near, reach = (0.0, bound) if self.around is None else (self.around[label], ZOOM * bound)
            numbers[label] = hp.uniform(label, max(-bound, near - reach), min(bound, near + reach))
        return numbers | {label: hp.choice(label, list(INVARIANCES)) for label in self._sides()}

    def parameters(self, point: Mapping[str, Any]) -> CurveParameters:
        """Translate a point into the parameters of the joints searched."""

        def column(name: str) -> Array:
            return np.array([point[f"{name}_{joint}"] for joint in self.joints])

        axes = np.stack([column(f"axis_{axis}") for axis in "xyz"], axis=-1) if self.family == "spd" else None
        if self.invariance == "joint":
            sides = tuple(point[f"side_{joint}"] for joint in self.joints)
        else:
            sides = (point.get("side", self.invariance),) * len(self.joints)
        metric = MetricParameters(np.exp(column("log_alpha")), np.exp(column("log_beta")), axes, sides)
        if self.scheme != "geodesic-spline":
            return CurveParameters.geodesic(metric)
        return CurveParameters(metric, 1.0 + column("bend"), 1.0 + column("path_bend"))

    def holds(self, point: object) -> bool:
        """Return whether a point from somewhere else is one of the whole space."""
        if not isinstance(point, dict) or set(point) != set(self.identity):
            return False
        numbers = all(type(point[each]) is float and abs(point[each]) <= top for each, top in self._bounds().items())
        return numbers and all(point[label] in INVARIANCES for label in self._sides())

    def _bounds(self) -> dict[str, float]:
        names = {"log_alpha": BOUND, "log_beta": BOUND}
        if self.family == "spd":
            names |= {f"axis_{axis}": _AXES_BOUND for axis in "xyz"}
        if self.scheme == "geodesic-spline":
            names |= {"bend": 1.0, "path_bend": 1.0}
        return {f"{name}_{joint}": float(bound) for joint in self.joints for name, bound in names.items()}

    def _sides(self) -> list[str]:
        if self.invariance == "joint":
            return [f"side_{joint}" for joint in self.joints]
        return ["side"] if self.invariance == "clip" else []


def search_tpe_joint(
    objective: Learnable,
    n_joints: int,
    family: str = "diagonal",
    invariance: str = "joint",
    scheme: str = "geodesic",
    seed: int = 0,
    settings: TuneSettings | None = None,
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
) -> Found:
    """Minimise an objective over metrics as the papers do: all parameters in one space, by HyperOpt on Ray Tune.

    Parameters
    ----------
    objective : Learnable
    n_joints : int
    family, invariance, scheme : str
        As in `search_gradient`.
    seed : int
        With one worker, the same seed gives the same result.
    settings : TuneSettings
    progress : callable
        Called with the number of trials and the best value so far.

    Returns
    -------
    found : Found
        Never worse than the bi-invariant metric with the usual tension.

    Raises
    ------
    ModuleNotFoundError
        If HyperOpt or Ray is missing; the message names the extra.
    ConnectionError
        If there is no Ray cluster at the address.
    ValueError
        If there is nothing to resume, or the folder is that of another search.
    """
    space = Space(range(n_joints), family, invariance, scheme)
    for module in ("hyperopt", "ray", "tensorboardX"):
        require(module)
    trials = require("geomstats_anim.learning.tune.trials")
    best, value, count = trials.run(objective, space, seed, settings or TuneSettings(), progress)
    return Found(space.parameters(best), value, count)


def search_tpe(
    objective: Learnable,
    n_joints: int,
    family: str = "diagonal",
    invariance: str = "joint",
    scheme: str = "geodesic",
    seed: int = 0,
    settings: TuneSettings | None = None,
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
) -> Found:
    """Minimise an objective over metrics with one small HyperOpt search per joint, from the roots to the leaves.

    It takes seconds, and neither starts Ray nor leaves a folder.

    Parameters
    ----------
    objective, n_joints, family, invariance, scheme, seed, settings, progress
        As in `search_tpe_joint`.

    Returns
    -------
    found : Found
        Never worse than the bi-invariant metric with the usual tension.

    Raises
    ------
    ModuleNotFoundError
        If HyperOpt is missing; the message names the extra.
    """
    settings = settings or TuneSettings()
    space = Space(range(n_joints), family, invariance, scheme)
    require("hyperopt")
    if settings.resume:
        raise ValueError("The search joint by joint takes seconds and cannot be resumed; start it again.")
    # joints that are searched one by one cannot agree on a side, so each is tried
    sides = INVARIANCES if invariance == "clip" else (invariance,)
    searches = [_JointByJoint(objective, replace(space, invariance=side), seed, settings, progress) for side in sides]
    found = [search.run() for search in searches]
    return replace(min(found, key=lambda one: one.value), evaluations=sum(one.evaluations for one in found))


class _JointByJoint:
    """Rotation errors first, all joints at once, as these need no other joint; then all errors, a level at a time."""

    def __init__(
        self,
        objective: Learnable,
        space: Space,
        seed: int,
        settings: TuneSettings,
        progress: Callable[[int, float], None],
    ) -> None:
        self._objective, self._space, self._seed, self._settings, self._progress = (
            objective,
            space,
            seed,
            settings,
            progress,
        )
        self._chosen = space.identity
        self._evaluations, self._best_value = 0, np.inf

    def run(self) -> Found:
        identity = self._space.parameters(self._chosen)
        self._search_in_step(self._space.joints, self._own)
        if self._objective.kind == "rot":
            self._search_in_step(self._space.joints, self._own, zoom=True)
        else:
            depths = self._objective.skeleton.depths
            levels = [[int(joint) for joint in np.flatnonzero(depths == depth)] for depth in np.unique(depths)]
            for zoom in (False, True):
                for joints in levels:
                    self._search_in_step(joints, self._from_here_down, zoom)
        found = [(self._objective.value(one), one) for one in (identity, self._space.parameters(self._chosen))]
        value, curve = min(found, key=lambda one: one[0])
        return Found(curve, value, self._evaluations)

    def _search_in_step(self, joints: Sequence[int], evaluate: Callable[[Point], Array], zoom: bool = False) -> None:
        """Search for joints at once, each by its own element of the errors, starting from what is chosen so far."""
        errors = evaluate({})
        searches = {}
        for joint in joints:
            space = replace(self._space, joints=[joint])
            if zoom:
                side = self._chosen.get(f"side_{joint}", space.invariance)
                space = replace(space, invariance=side, around=self._chosen)
            start = {label: self._chosen[label] for label in space.identity}
            searches[joint] = JointSearch(space, start, errors[joint], [self._seed, joint])
        settings = self._settings
        window = JOINT_WINDOW if settings.window is None else settings.window
        going_on = {joint: Convergence(window, settings.threshold) for joint in joints}
        for _ in range((settings.trials or JOINT_TRIALS) - 1):
            asked = {joint: searches[joint].ask() for joint in going_on}
            errors = evaluate({label: value for point in asked.values() for label, value in point.items()})
            for joint in asked:
                searches[joint].tell(errors[joint])
                if going_on[joint].reached(errors[joint]):
                    del going_on[joint]
            if not going_on:
                break
        for search in searches.values():
            self._chosen |= search.best_point

    def _own(self, point: Point) -> Array:
        """Return the rotation error of each joint, shape=[B]."""
        return self._errors(point)[0]

    def _from_here_down(self, point: Point) -> Array:
        """Return the errors of each joint and those below it, shape=[B]: all that its metric affects."""
        errors = self._errors(point)[1]
        parents = self._objective.skeleton.parents
        for joint in reversed(range(len(parents))):
            if parents[joint] >= 0:
                errors[parents[joint]] += errors[joint]
        return errors

    def _errors(self, point: Point) -> Array:
        errors = self._objective.errors_by_joint(self._space.parameters(self._chosen | point))
        self._evaluations += 1
        self._best_value = min(self._best_value, float(errors[1].sum()))
        self._progress(self._evaluations, self._best_value)
        return errors


class JointSearch:
    """HyperOpt, to ask for points and to tell their values.

    Parameters
    ----------
    space : Space
    start : dict
        First point.
    value : float
        Its value.
    seed : sequence of int
    """

    def __init__(self, space: Space, start: Point, value: float, seed: Sequence[int]) -> None:
        base, tpe = require("hyperopt.base"), require("hyperopt.tpe")
        self._suggest = partial(tpe.suggest, n_startup_jobs=STARTUP, verbose=False)
        self._domain, self._trials = base.Domain(dict, space.expression()), base.Trials()
        self._random = np.random.default_rng(list(seed))
        self.best_point, self.best_value = start, np.inf
        self._asked, self._document = start, as_document(start, self._trials, self._domain)
        self.tell(value)

    def ask(self) -> Point:
        """Suggest a point."""
        numbers = self._trials.new_trial_ids(1)
        (self._document,) = self._suggest(numbers, self._domain, self._trials, int(self._random.integers(2**31 - 1)))
        self._asked = point_of(self._document)
        return self._asked

    def tell(self, value: float) -> None:
        """Take the value of the point suggested last."""
        finish(self._document, value, self._trials)
        if value < self.best_value:
            self.best_point, self.best_value = self._asked, value


def as_document(point: Mapping[str, Any], trials: Any, domain: Any) -> dict[str, Any]:
    """Write a point that HyperOpt did not suggest as it writes its own."""
    (number,) = trials.new_trial_ids(1)
    values = {label: [INVARIANCES.index(v) if isinstance(v, str) else v] for label, v in point.items()}
    misc = {"tid": number, "cmd": domain.cmd, "workdir": domain.workdir}
    misc |= {"idxs": {label: [number] for label in point}, "vals": values}
    (document,) = trials.new_trial_docs([number], [None], [domain.new_result()], [misc])
    return dict(document)


def point_of(document: Mapping[str, Any]) -> Point:
    """Read the point of one of HyperOpt's documents."""
    values = {label: value for label, (value,) in document["misc"]["vals"].items()}
    return {
        label: INVARIANCES[int(value)] if label.startswith("side") else float(value) for label, value in values.items()
    }


def finish(document: dict[str, Any], value: float, trials: Any) -> None:
    """Enter a document into HyperOpt's trials, with the value of its point."""
    document["result"] = {"loss": float(value), "status": "ok"}
    document["state"] = require("hyperopt.base").JOB_STATE_DONE
    trials.insert_trial_docs([document])
    trials.refresh()
