"""
Your own metric
===============

A metric need not be learned. Any positive numbers, axes and sides make one.
"""

# %%
# By hand
# -------
# A bone that twists easily, and bends with effort; its x axis is along the bone. The way from one rotation to another
# is shared out differently.

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace

end = Rotation.from_euler("xyz", [100.0, 60.0, 40.0], degrees=True).as_matrix()
times = np.linspace(0.0, 1.0, 41)
figure, axes = plt.subplots(1, 3, figsize=(10, 3), sharey=True)
for panel, (title, alpha, beta) in zip(
    axes,
    (("every turn alike", 1.0, 1.0), ("twist is cheap", 8.0, 8.0), ("bending about y is cheap", 0.15, 1.0)),
    strict=True,
):
    space = PoseSpace(1, equip=False)
    space.equip_with_metric(PoseMetric, parameters=MetricParameters(alpha, beta))
    path = space.metric.geodesic(space.identity, end_point=end[None])(times)[:, 0]
    angles = Rotation.from_matrix(path).as_euler("xyz", degrees=True)
    for values, color, name in zip(angles.T, ("#7b3fb5", "#d81b60", "#1d9a8a"), "xyz", strict=True):
        panel.plot(times, values, color=color, label=name)
    panel.set(title=title, xlabel="time")
axes[0].set_ylabel("Euler angle, degrees")
axes[0].legend()
figure.tight_layout()
plt.show()

# %%
# Any matrix
# ----------
# The inertia of a bone is a symmetric positive definite matrix: kinetic energy is a metric, and its geodesics are what
# the bone does where nothing acts on it. Its principal axes need not be those of the joint.

masses = np.array([1.0, 2.0, 0.5, 1.5])
places = np.array([[0.3, 0.0, 0.0], [0.1, 0.2, 0.0], [0.0, 0.0, 0.3], [-0.1, 0.1, 0.1]])
squares = (places**2).sum(axis=1)
inertia = (masses * squares).sum() * np.eye(3) - np.einsum("n,ni,nj->ij", masses, places, places)
parameters = MetricParameters.from_matrices(inertia[None])
print(parameters)
space = PoseSpace(1, equip=False).equip_with_metric(PoseMetric, parameters=parameters)
print("scalar curvature:", space.metric.scalar_curvature().round(3))

# %%
# It tumbles: the angular velocity in the body along one geodesic.

vector = space.metric.from_coordinates(np.array([0.3, 4.0, 0.2]), space.identity)
times = np.linspace(0.0, 30.0, 900)
path = space.metric.geodesic(space.identity, initial_tangent_vec=vector)(times)[:, 0]
turns = Rotation.from_matrix(np.swapaxes(path[:-1], -1, -2) @ path[1:]).as_rotvec() / np.diff(times)[:, None]
velocity = turns @ Rotation.from_rotvec(np.array(parameters.axes[0])).as_matrix().T
figure, axes = plt.subplots(figsize=(9, 3), layout="constrained")
for values, color, name in zip(velocity.T, ("#7b3fb5", "#d81b60", "#1d9a8a"), ("1", "2", "3"), strict=True):
    axes.plot(times[:-1], values, color=color, label=f"principal axis {name}")
axes.set(xlabel="time", ylabel="radians per unit of time")
axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
plt.show()
