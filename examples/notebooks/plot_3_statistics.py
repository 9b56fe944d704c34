"""
Statistics of poses
===================

The estimators of ``geomstats.learning`` on poses: a mean, components that are drawn as skeletons, clusters.
"""

# %%
# The mean pose
# -------------
# The Frechet mean of a clip, of every pose the same weight.

import matplotlib.pyplot as plt
import numpy as np
from drawing import clip, draw, posed

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace
from geomstats_anim.riemannian.estimators import AgglomerativeHierarchicalClustering, TangentPCA, mean_estimator
from geomstats_anim.rotations import to_matrix

jump = clip("jumping")
poses = to_matrix(jump.rotations)
space = PoseSpace(jump.n_joints, equip=False)
space.equip_with_metric(PoseMetric, parameters=MetricParameters.identity(jump.n_joints))
mean = mean_estimator(space).fit(poses).estimate_
gradient = space.metric.norm(space.metric.log(poses, mean).mean(axis=0), mean)
print(f"the gradient at the mean: {gradient:.1e}")

# %%
# Eigenposes
# ----------
# Principal components of the tangent space at the mean, with the metric's own inner product. Each row goes along one of
# them, two standard deviations to either side; the mean is in the middle.

pca = TangentPCA(space, n_components=3).fit(poses)
figure, axes = plt.subplots(3, 5, figsize=(8, 7.5), sharex=True, sharey=True)
for number, row in enumerate(axes):
    deviation = np.sqrt(pca.explained_variance_[number])
    scores = np.zeros((5, 3))
    scores[:, number] = deviation * np.linspace(-2.0, 2.0, 5)
    eigenposes = posed(jump, pca.inverse_transform(scores))
    for column, panel in enumerate(row):
        draw(panel, eigenposes, column, "#7b3fb5" if column != 2 else "#2b2d42")
    share = pca.explained_variance_ratio_[number]
    row[0].set_title(f"component {number + 1}: {100 * share:.0f} % of the variance", loc="left", fontsize=9)
plt.show()

# %%
# Clusters
# --------
# The poses of three clips together, the roots left out, fall into groups by their distances; every group has a colour.

names = ("jumping", "punching", "sitting")
clips = [clip(name) for name in names]
together = np.concatenate([to_matrix(animation.rotations[::3, 1:]) for animation in clips])
labels = np.repeat(np.arange(3), [len(animation.rotations[::3]) for animation in clips])
bodies = PoseSpace(together.shape[1])
groups = AgglomerativeHierarchicalClustering(bodies, n_clusters=6).fit(together).labels_

figure, axes = plt.subplots(figsize=(9, 2.2))
for row in range(3):
    mine = groups[labels == row]
    axes.scatter(
        np.arange(len(mine)) / 10.0, np.full(len(mine), -row), c=mine, cmap="Dark2", vmin=0, vmax=7, s=60, marker="s"
    )
axes.set(yticks=[0, -1, -2], yticklabels=names, xlabel="seconds", ylim=(-2.6, 0.6))
axes.spines[["top", "right", "left"]].set_visible(False)
figure.tight_layout()
plt.show()
