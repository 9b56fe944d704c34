"""Settings of `learn_metric`, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from geomstats_anim.names import (
    ALL_FAMILIES,
    DEFAULT_SCHEME,
    FAMILIES,
    INVARIANCE_CHOICES,
    LEARNABLE,
    PURPOSES,
    SEARCHES,
)

if TYPE_CHECKING:
    from geomstats_anim.learning.tune.settings import TuneSettings


@dataclass(frozen=True, eq=False)
class LearnSettings:
    """Settings of `learn_metric`.

    Parameters
    ----------
    search, purpose, family, invariance, scheme, kind : str
    seed : int
    weights : None, "depth" or array-like, shape=[B]
    location_weight : float
    tune : TuneSettings or None
    rough : bool

    Raises
    ------
    ValueError
        If a word is unknown, or the family has no such search or purpose.
    """

    search: str = "gradient"
    purpose: str = "reconstruct"
    family: str = "diagonal"
    invariance: str = "joint"
    scheme: str = DEFAULT_SCHEME
    kind: str = "hyb"
    seed: int = 0
    weights: str | ArrayLike | None = None
    location_weight: float = 0.5
    tune: TuneSettings | None = None
    rough: bool = False

    def __post_init__(self) -> None:
        """Check the words; the kind and the weights are checked where they are used."""
        for name, words in (("search", SEARCHES), ("purpose", PURPOSES), ("scheme", LEARNABLE)):
            word = getattr(self, name)
            if word not in words:
                raise ValueError(f"There is no {name} {word!r}; the choices are {', '.join(words)}.")
        check_words(self.family, self.invariance, ALL_FAMILIES)
        if self.family == "coupled" and (self.search, self.purpose) != (SEARCHES[0], PURPOSES[0]):
            raise ValueError(
                f'The family "coupled" is learned with the search "{SEARCHES[0]}" and the purpose "{PURPOSES[0]}" only.'
            )


def check_words(family: str, invariance: str, families: Sequence[str] = FAMILIES) -> None:
    """Refuse an unknown family or invariance.

    Raises
    ------
    ValueError
    """
    if family not in families:
        raise ValueError(f"There is no family {family!r}; the families are {', '.join(families)}.")
    if invariance not in INVARIANCE_CHOICES:
        raise ValueError(f"There is no invariance {invariance!r}; the choices are {', '.join(INVARIANCE_CHOICES)}.")
