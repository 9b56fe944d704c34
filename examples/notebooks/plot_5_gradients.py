"""
Gradients
=========

Geodesics are differentiated exactly by their ends and by the metric, so that a metric can stand inside a loss. This
page uses autograd; ``torch_functions`` has the same functions for PyTorch, with ``backward`` in the place of ``grad``.
"""

# %%
# A loss with a metric inside
# ---------------------------
# A metric that nobody tells us bends the way between poses. We see only the poses half way, and find alpha and beta.

import autograd
import autograd.numpy as anp
import matplotlib.pyplot as plt
import numpy as np
from drawing import clip
from scipy.optimize import minimize

from geomstats_anim.riemannian import autograd_functions
from geomstats_anim.rotations import to_matrix

animation = clip("rolling")
turned = np.abs(np.diff(animation.rotations[::20], axis=0)).sum(axis=(0, 2))
moving = np.argsort(turned)[-6:]  # the joints that move most
poses = to_matrix(animation.rotations[::20, moving])
starts, ends = poses[:-1], poses[1:]
n_bones = starts.shape[1]
rng = np.random.default_rng(0)
hidden = 0.7 * rng.normal(size=(2, n_bones))
seen = autograd_functions.geodesic(starts, ends, [0.5], *np.exp(hidden))


def loss(logarithms):
    """Miss the poses half way, with alpha and beta that are exponentials, so that they stay positive."""
    alpha, beta = anp.exp(logarithms[0]), anp.exp(logarithms[1])
    return anp.sum((autograd_functions.geodesic(starts, ends, [0.5], alpha, beta) - seen) ** 2)


history = []


def value_and_gradient(flat):
    """Return what SciPy's minimizers take."""
    value, gradient = autograd.value_and_grad(loss)(flat.reshape(2, n_bones))
    history.append(value)
    return value, gradient.ravel()


found = minimize(value_and_gradient, np.zeros(2 * n_bones), jac=True, method="BFGS", options={"gtol": 1e-9})
print("alpha, found :", np.exp(found.x.reshape(2, n_bones)[0]).round(4))
print("alpha, hidden:", np.exp(hidden[0]).round(4))

figure, axes = plt.subplots(figsize=(6, 3))
axes.semilogy(history, "o-", color="#7b3fb5", ms=3)
axes.set(xlabel="evaluations", ylabel="loss")
axes.spines[["top", "right"]].set_visible(False)
figure.tight_layout()
plt.show()

# %%
# Exact, not approximate
# ----------------------
# The derivative by a direction, against differences of the loss with smaller and smaller steps: their error falls,
# until rounding takes over.

point, direction = 0.3 * rng.normal(size=(2, 2, n_bones))
slope = np.sum(autograd.grad(loss)(point) * direction)
sizes = np.geomspace(1e-1, 1e-9, 17)
errors = [
    abs((loss(point + size * direction) - loss(point - size * direction)) / (2 * size) - slope) / abs(slope)
    for size in sizes
]
figure, axes = plt.subplots(figsize=(6, 3))
axes.loglog(sizes, errors, "o-", color="#d81b60", ms=4)
axes.set(xlabel="step of the difference", ylabel="relative error")
axes.spines[["top", "right"]].set_visible(False)
figure.tight_layout()
plt.show()

# %%
# In PyTorch
# ----------
# The same loss, with ``pip install 'geomstats-anim[torch]'``:
#
# .. code-block:: python
#
#    import torch
#    from geomstats_anim.riemannian import torch_functions
#
#    logarithms = torch.zeros(2, n_bones, dtype=torch.float64, requires_grad=True)
#    optimizer = torch.optim.Adam([logarithms], lr=0.1)
#    for _ in range(200):
#        optimizer.zero_grad()
#        middle = torch_functions.geodesic(starts, ends, [0.5], *logarithms.exp())
#        ((middle - torch.as_tensor(seen)) ** 2).sum().backward()
#        optimizer.step()
