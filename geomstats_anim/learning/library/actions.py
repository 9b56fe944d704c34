"""Actions of a library: clusters of its clips, by what surrounds their segments."""

from __future__ import annotations

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from geomstats_anim.learning.library.features import Features
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.learning.library.samples import Samples

_MOST_ACTIONS = 5


def cluster_clips(samples: Samples, parts: BodyParts, n_clips: int) -> np.ndarray:
    """Cluster clips by the mean features of their segments, by Ward's criterion.

    Parameters
    ----------
    samples : Samples
    parts : BodyParts
    n_clips : int
        Of the library; those without segments are in one cluster.

    Returns
    -------
    actions : array-like of int, shape=[n_clips]
    """
    actions = np.zeros(n_clips, dtype=np.intp)
    contexts, scales = samples.contexts, samples.contexts.scales(parts)
    features = np.concatenate(Features.fitted(contexts, scales, parts)(contexts, scales)[:-1], axis=1)
    present = np.unique(samples.clip)
    if len(present) > 1:
        means = np.stack([features[samples.clip == clip].mean(axis=0) for clip in present])
        actions[present] = fcluster(linkage(means, "ward"), _MOST_ACTIONS, "maxclust")
    return actions
