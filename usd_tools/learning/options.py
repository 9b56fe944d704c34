"""Options of `learn`."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

from geomstats_anim.names import DEFAULT_SCHEME, FAMILIES, INVARIANCE_CHOICES, KINDS, LEARNABLE, PURPOSES, SEARCHES
from usd_tools.console.arguments import seed, share, whole_number
from usd_tools.console.errors import UsageError
from usd_tools.console.options import OutputOptions, one_of, option

PAPERS_RATE = 0.3
"""Share of samples kept as keys in most of the papers' figures."""

LIBRARY_SUFFIX = ".inbetween"
"""Of files that hold a library."""


@dataclass(frozen=True, kw_only=True)
class LearnOptions(OutputOptions):
    """Options of `learn`, in the words of its command line.

    Parameters
    ----------
    rate : float
        Share of the samples kept as keys, from which the others are rebuilt.
        Optional, default: 0.3, the papers'.
    search : str
        "gradient", "tpe" or "tpe-joint".
        Optional, default: "gradient".
    purpose : str
        "reconstruct": fit these samples; "predict": only what cross-validation shows to carry over to others.
        Optional, default: "reconstruct".
    library : bool
        With "predict": learn what splines miss of these clips, for other clips of the rig, instead of a metric.
    family : str
        "diagonal" or "spd".
        Optional, default: "diagonal".
    invariance : str
        "left", "right", "clip" (the better side for all joints) or "joint" (for each).
        Optional, default: "joint".
    scheme : str
        Interpolation scheme that the metric is for.
        Optional, default: "geodesic-spline".
    kind : str
        Quality to minimise: "loc", "rot" or "hyb".
        Optional, default: "hyb".
    weights : str
        "depth" for the papers' weights.
        Optional, default: every joint weighs the same.
    seed : int
        Of the TPE searches.
        Optional, default: 0.
    skip_mismatched : bool
        Whether to skip animations whose rig differs from the first.
    trials : int
        Most evaluations of a TPE search; for "tpe", of each joint.
    folder, resume : Path
        Where "tpe-joint" leaves its results, or goes on with those of a search that was stopped.
    address : str
        HOST:PORT of a Ray cluster.
    cpus : int
        Workers; more than one starts Ray.
        Optional, default: 1.
    wandb : str
        Project of Weights & Biases that "tpe-joint" logs to.
    """

    rate: float = option(PAPERS_RATE, share)
    search: str = option(SEARCHES[0], one_of(SEARCHES))
    purpose: str = option(PURPOSES[0], one_of(PURPOSES))
    library: bool = option(False, bool)
    family: str = option(FAMILIES[0], one_of(FAMILIES))
    invariance: str = option("joint", one_of(INVARIANCE_CHOICES))
    scheme: str = option(DEFAULT_SCHEME, one_of(LEARNABLE))
    kind: str = option("hyb", one_of(KINDS))
    weights: str | None = option(None, one_of(("depth",)))
    seed: int = option(0, seed)
    skip_mismatched: bool = option(False, bool, recorded=False)
    trials: int | None = option(None, whole_number)
    folder: Path | None = option(None, Path, recorded=False)
    resume: Path | None = option(None, Path, recorded=False)
    address: str | None = option(None, str, recorded=False)
    cpus: int | None = option(None, whole_number, recorded=False)
    wandb: str | None = option(None, str, recorded=False)

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.library:
            self._check_library()
        needed = {"trials": SEARCHES[1:], "folder": SEARCHES[2:], "resume": SEARCHES[2:], "wandb": SEARCHES[2:]}
        for word, searches in needed.items():
            if getattr(self, word) is not None and self.search not in searches:
                raise UsageError(f"--{word} goes with --search {' or '.join(searches)}")
        if self.folder is not None and self.resume is not None:
            raise UsageError("--folder starts a search and --resume continues one; leave one of them out")
        if (self.folder or self.resume) and self.purpose == "predict":
            raise UsageError("--folder and --resume hold one search, but --purpose predict runs several")

    def _check_library(self) -> None:
        if self.purpose != "predict":
            raise UsageError("--library needs --purpose predict")
        usual = {each.name: each.default for each in fields(self)}
        for word in ("rate", "search", "family", "invariance", "scheme", "kind", "weights"):
            if getattr(self, word) != usual[word]:
                raise UsageError(f"--{word} is for a metric, and --library learns none; leave it out")
