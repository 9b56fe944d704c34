"""Learning the metric whose geodesics rebuild an animation from few keys."""

from geomstats_anim.learning.learn import learn_metric

__all__ = ["learn_metric"]
