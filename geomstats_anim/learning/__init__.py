"""Learning the metric whose geodesics rebuild an animation best from few of its frames, and which frames those are."""

from geomstats_anim.learning.compression import Compressed, compress
from geomstats_anim.learning.learn import learn_metric

__all__ = ["Compressed", "compress", "learn_metric"]
