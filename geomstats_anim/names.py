"""The words that options and files use: the one place for them, without dependencies, so that parsers need no more."""

from collections.abc import Sequence

OWN_SCHEMES = ("constant", "linear", "slerp", "squad", "rotation-spline", "geodesic", "geodesic-spline")
"""Interpolation schemes that need nothing but the clip."""

LEARNED = "learned"
"""The scheme that needs a library of other clips."""

SCHEME_NAMES = (*OWN_SCHEMES, LEARNED)
"""Interpolation schemes."""

LEARNABLE = ("geodesic", "geodesic-spline")
"""Schemes whose metric can be learned."""

WITH_METRIC = (*LEARNABLE, LEARNED)
"""Schemes that have a metric."""

BENT = ("geodesic-spline", LEARNED)
"""Schemes whose curves are bent by a tension."""

DEFAULT_SCHEME = "geodesic-spline"
"""Used where neither the user nor a metric asks for another: with the identity metric it predicts best."""

MAX_TENSION = 2.0
"""Tension of a curve with continuous acceleration, the largest; see `interpolation.tangents`."""

INVARIANCES = ("left", "right")
"""Sides of a joint's metric."""

INVARIANCE_CHOICES = (*INVARIANCES, "clip", "joint")
"""Sides to learn: a given one, the better one for all joints, or the better one for each joint."""

FAMILIES = ("diagonal", "spd")
"""Families of matrices to learn from, each contained in the next."""

ALL_FAMILIES = (*FAMILIES, "coupled")
"""The same with matrices over all joints, which are for Python: USD attributes hold one matrix per joint."""

KINDS = ("loc", "rot", "hyb")
"""Kinds of quality."""

LARGEST = "max"
"""Criterion that counts only the largest distance of a marker."""

SHELL_RADIUS = 0.03
"""Metres from a joint to the points of its shell: about half the thickness of a forearm."""

WEIGHTS_TOLERANCE = 0.01
"""Default tolerance of blend shape weights: they are authored in percent, and less than this is not seen."""

EFFORTS = ("full", "fast")
"""Efforts of packing, the default first."""

MEASURES = ("ends", "shell", "skin")
"""Points that a tolerance is about: joints and bone ends; points around joints too; points of the skin too."""

CRITERIA = (*KINDS, LARGEST)
"""Criteria by which keys may be chosen."""

SELECTIONS = ("optimal", "uniform")
"""Ways to choose keys, the default first."""

PURPOSES = ("reconstruct", "predict")
"""Purposes to learn for, the default first."""

SEARCHES = ("gradient", "tpe", "tpe-joint")
"""Searches for a metric, the default first."""

TRIALS, JOINT_TRIALS = 1000, 100
"""Default number of trials of the search over all joints at once, and of the search for each joint."""

GAP, SPIKE, DROPOUT = "gap", "spike", "drop-out"
"""Faults of recorded motion; see `geomstats_anim.faults`."""


def repeated_name(names: Sequence[str]) -> str | None:
    """Return the first name that is there before, or None."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None
