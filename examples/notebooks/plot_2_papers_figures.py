"""
The papers' figures 1, 4 and 5
==============================

Kushner, Modi and Miolane compare interpolation schemes on five clips; these are the example clips of the same names.
"""

# %%
# Figure 1: one frame by every scheme
# -----------------------------------
# One of ten frames of the pitch is kept, and all are interpolated again. The original is grey.

import matplotlib.pyplot as plt
import numpy as np
from drawing import clip, draw

from geomstats_anim import interpolate, learn_metric, quality, uniform_keyframes
from usd_tools.figures.style import TRUTH, look

RATE = 0.1
pitch = clip("pitching")
keys = uniform_keyframes(pitch.n_frames, RATE)
metric = learn_metric(pitch, keys, scheme="geodesic")
rebuilt = {
    scheme: interpolate(pitch.at_frames(keys), pitch.times, scheme, metric if scheme == "geodesic" else None)
    for scheme in ("constant", "linear", "slerp", "geodesic")
}
dots = np.abs((rebuilt["slerp"].rotations * pitch.rotations).sum(axis=-1)).clip(max=1.0)
frame = int(np.arccos(dots).sum(axis=1).argmax())  # the one that slerp misses most

figure, axes = plt.subplots(1, 4, figsize=(10, 3.4), sharex=True, sharey=True)
for panel, (scheme, animation) in zip(axes, rebuilt.items(), strict=True):
    draw(panel, pitch, frame, TRUTH, linewidth=7.0)
    draw(panel, animation, frame, look(scheme).color)
    panel.set_title(f"{scheme}\n$Q_{{hyb}}$ = {quality(animation, pitch):.3f}", fontsize=10)
plt.show()

# %%
# Figure 4: the pipeline
# ----------------------
# Downsample, learn the metric with which the geodesics rebuild the original best, upsample, compare.

figure, axes = plt.subplots(3, 1, figsize=(10, 6.5), sharex=True, sharey=True)
rows = (
    ("ground truth", pitch, np.arange(0, pitch.n_frames, 7), TRUTH),
    (f"initial animation: {len(keys)} of {pitch.n_frames} frames", pitch, keys, "#d81b60"),
    (
        "interpolated along geodesics of the learned metric",
        rebuilt["geodesic"],
        np.arange(0, pitch.n_frames, 7),
        "#7b3fb5",
    ),
)
for panel, (title, animation, frames, color) in zip(axes, rows, strict=True):
    for number in frames:
        draw(panel, animation, number, color, shift=number / 12.0, linewidth=1.6)
    panel.set_title(title, loc="left", fontsize=10)
plt.show()

# %%
# Figure 5: four clips, overlaid
# ------------------------------
# The frame that slerp misses most; the original is grey, slerp yellow, the geodesic of a learned metric violet.

figure, axes = plt.subplots(1, 4, figsize=(10, 3.4))
for panel, name in zip(axes, ("sitting", "jumping", "punching", "rolling"), strict=True):
    animation = clip(name)
    keys = uniform_keyframes(animation.n_frames, RATE)
    metric = learn_metric(animation, keys, scheme="geodesic")
    slerp = interpolate(animation.at_frames(keys), animation.times, "slerp")
    geodesic = interpolate(animation.at_frames(keys), animation.times, "geodesic", metric)
    dots = np.abs((slerp.rotations * animation.rotations).sum(axis=-1)).clip(max=1.0)
    worst = int(np.arccos(dots).sum(axis=1).argmax())
    draw(panel, animation, worst, TRUTH, linewidth=7.0)
    draw(panel, slerp, worst, look("slerp").color)
    draw(panel, geodesic, worst, look("geodesic").color)
    share = quality(geodesic, animation) / quality(slerp, animation)
    panel.set_title(f"{name}, frame {worst}\n{100 * (1 - share):.0f} % less error", fontsize=10)
plt.show()
