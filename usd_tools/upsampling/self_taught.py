"""`upsample --metric learn`: a metric that an animation teaches itself before it is upsampled.

Every other sample is kept as a key, and the metric is sought that predicts the samples between: that is the same task
as putting a new sample into every gap, at twice the spacing, and the only spacing near to it at which the truth is
known. What is wanted are frames that nobody has seen, so the purpose is to predict: blocked cross-validation shrinks
the metric towards the bi-invariant one, and keeps that unless it is sure of a gain. The search is the gradient's.
"""

from __future__ import annotations

from pathlib import Path

from geomstats_anim import LearnedMetric
from geomstats_anim.names import DEFAULT_SCHEME, WITH_METRIC
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import SearchProgress
from usd_tools.learning.clips import take_of
from usd_tools.learning.train import Recipe, teach
from usd_tools.skel.clip import SkelClip

RATE = 0.5


def taught_by_itself(path: Path, clip: SkelClip, scheme: str | None, messages: Messages) -> LearnedMetric:
    """Learn a metric from an animation, and say on stdout what it brings.

    Parameters
    ----------
    path : Path
        File that the animation is in.
    clip : SkelClip
    scheme : str or None
        Scheme to learn for; None for the usual one.
    messages : Messages
        Told if there is nothing to learn from, so that the identity is used.

    Returns
    -------
    metric : LearnedMetric

    Raises
    ------
    ToolError
        If nothing can be learned for the scheme.
    """
    if scheme is not None and scheme not in WITH_METRIC:
        raise ToolError(
            f"--metric learn learns for --scheme {', '.join(WITH_METRIC)}, not for {scheme}; choose one of them."
        )
    recipe = Recipe(rate=RATE, purpose="predict", scheme=scheme or DEFAULT_SCHEME)
    try:
        take = take_of(path, clip)
        with SearchProgress(None) as progress:
            lesson = teach([take], recipe, progress.watch)
    except ToolError as error:
        messages.warn(f"{str(error).rstrip('.')}; the identity is used.")
        return LearnedMetric.plain(clip.joints, recipe.scheme)
    if lesson.is_plain:
        plain = "the plain spline" if recipe.scheme == "geodesic-spline" else "slerp"
        gained = f"nothing is sure to predict the others better than {plain}: a tie, and it is kept"
    else:
        unseen = lesson.cross_validated
        assert unseen is not None
        tie = ", which is a tie" if unseen.ties else ""
        gained = f"the others are predicted, cross-validated, {unseen.beside_rival}{tie}"
    print(f"{clip.path}: learned from every other sample; {gained}.")
    return lesson.metric
