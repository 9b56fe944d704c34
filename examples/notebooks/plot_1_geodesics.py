"""
Geodesics of poses in five minutes
==================================

A pose of a character is a rotation for each of its bones: a point of the Lie group :math:`SO(3)^B`. A metric on it says
which turns are cheap, and its geodesics are the in-betweens.
"""

# %%
# A space and a metric
# --------------------
# ``PoseSpace`` is a manifold of Geomstats. A metric has two numbers for each bone, alpha and beta: what turns about its
# y and z axes cost, where one about x costs 1.

import matplotlib.pyplot as plt
import numpy as np
from drawing import clip, draw, posed

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace
from geomstats_anim.rotations import to_matrix

pitch = clip("pitching")
n_bones = pitch.n_joints
parameters = MetricParameters(alpha=np.full(n_bones, 8.0), beta=np.full(n_bones, 0.15))
space = PoseSpace(n_bones, equip=False).equip_with_metric(PoseMetric, parameters=parameters)
print(space)

# %%
# Geodesics
# ---------
# Two poses of the clip, and the geodesic between them. With the bi-invariant metric it is slerp, bone by bone.

start, end = to_matrix(pitch.rotations[[45, 78]])
times = np.linspace(0.0, 1.0, 5)
path = space.metric.geodesic(start, end_point=end)(times)
slerp = PoseSpace(n_bones).metric.geodesic(start, end_point=end)(times)

figure, axes = plt.subplots(figsize=(9, 3.2))
for column in range(5):
    draw(axes, posed(pitch, slerp), column, "#e8b400", shift=1.3 * column, linewidth=2.0)
    draw(axes, posed(pitch, path), column, "#7b3fb5", shift=1.3 * column)
axes.set_title("slerp (yellow) and a geodesic (violet) between the same two poses")
plt.show()

# %%
# Distances, and how sure they are
# --------------------------------
# Distances are lengths of the shortest geodesics. ``log_solver.solve`` says of each bone how the search ended.

print("distance:", space.metric.dist(start, end).round(3))
result = space.metric.log_solver.solve(end, start)
print("largest miss of the end, in radians:", result.residual.max())
print("geodesics up to this length are certainly the shortest:", space.metric.injectivity_radius().round(3))

# %%
# Whatever batch axes points have, one call does them all.

poses = to_matrix(pitch.rotations[::4])
print("distances between", len(poses), "poses:", space.metric.dist_pairwise(poses).shape)
