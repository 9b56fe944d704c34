"""
Learning a metric, and what it means
====================================

The metric is learned from the frames of a clip that are left out: those with which the others are rebuilt best.
"""

# %%
# Learn
# -----

import matplotlib.pyplot as plt
import numpy as np
from drawing import clip

from geomstats_anim import MetricParameters, interpolate, learn_metric, quality, uniform_keyframes

animation = clip("rolling")
keys = uniform_keyframes(animation.n_frames, 0.15)
metric = learn_metric(animation, keys)
print(metric.parameters)

scores = {
    "slerp": quality(interpolate(animation.at_frames(keys), animation.times, "slerp"), animation),
    "plain spline": quality(interpolate(animation.at_frames(keys), animation.times), animation),
    "learned": quality(interpolate(animation.at_frames(keys), animation.times, metric=metric), animation),
}
for name, score in scores.items():
    print(f"Q_hyb of {name:12s} {score:.4f}")

# %%
# What it says
# ------------
# At alpha and beta 1 every turn of a bone costs the same. A bone on the right is stiff about its y axis, one on the
# left turns about it first.

short = [name.rpartition("/")[2] for name in animation.skeleton.joints]
order = np.argsort(metric.parameters.alpha)
figure, axes = plt.subplots(figsize=(8, 6))
for values, color, label in (
    (metric.parameters.alpha, "#7b3fb5", "alpha: y against x"),
    (metric.parameters.beta, "#f07f1b", "beta: z against x"),
):
    axes.plot(values[order], np.arange(len(order)), "o", color=color, label=label)
axes.set(xscale="log", yticks=np.arange(len(order)), yticklabels=np.array(short)[order])
axes.axvline(1.0, color="#b9bac4", zorder=0)
axes.legend()
figure.tight_layout()
plt.show()

# %%
# The landscape of one bone
# -------------------------
# The error of one bone by its own alpha and beta, the others as learned for plain geodesics: the dot is what was found.

metric = learn_metric(animation, keys, scheme="geodesic")
parameters = metric.parameters
joint = int(np.ptp(animation.rotations, axis=0).sum(axis=1).argmax())  # the one that moves most
steps = np.geomspace(0.08, 12.5, 15)
grid = np.empty((15, 15))
for row, beta in enumerate(steps):
    for column, alpha in enumerate(steps):
        alphas, betas = parameters.alpha.copy(), parameters.beta.copy()
        alphas[joint], betas[joint] = alpha, beta
        trial = MetricParameters(alphas, betas, parameters.axes, parameters.invariance)
        grid[row, column] = quality(
            interpolate(animation.at_frames(keys), animation.times, "geodesic", trial), animation
        )
figure, axes = plt.subplots(figsize=(5, 4))
shades = axes.contourf(steps, steps, grid, 20, cmap="viridis_r")
axes.plot(parameters.alpha[joint], parameters.beta[joint], "o", color="white", mec="black")
axes.set(xscale="log", yscale="log", xlabel="alpha", ylabel="beta", title=short[joint])
figure.colorbar(shades, label="$Q_{hyb}$")
figure.tight_layout()
plt.show()
