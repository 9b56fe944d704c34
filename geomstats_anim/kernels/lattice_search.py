"""Search for the integers of a packed motion: few bits, and every marker near its place.

One component of one joint is visited at a time. Along it every marker moves on a line, to first order, so that its
squared distance from its place is a quadratic, and a sum of eighth powers a polynomial of degree eight per frame. Sums
over all that hangs below the joint are taken once per visit; a trial is then a polynomial over the support of a basis
function. Errors themselves are measured anew, exactly, by every visit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.kernels import affine, vectors
from geomstats_anim.kernels.compilation import compiled, inlined
from geomstats_anim.kernels.contexts import PLAIN, ROTATION, class_of, expected_beside, expected_in_time

TERMS = 9
"""Coefficients of a polynomial of degree eight."""

LARGEST = 31
"""Magnitudes from here on share the statistics of the search."""


class Pose(NamedTuple):
    """A motion while it is searched, and where its markers should be.

    Attributes
    ----------
    vectors, translations, scales : array-like, shape=[F, B, 3]
        Rotation vectors at `references`, and the rest of the motion.
    references : array-like, shape=[B, 4]
    plain, plain_targets : array-like, shape=[F, N, 3]
        Numbers that place nothing, and what they should be.
    plain_tolerances : array-like, shape=[N]
    world : array-like, shape=[F, 3, 4]
    locals, matrices : array-like, shape=[F, B, 3, 4]
        Of joints, to their parents and to the world.
    parents : array-like of int, shape=[B]
    below : array-like of int, shape=[B + 1]
        Where the joints below each, itself first, are in `members`.
    members, member_parents : array-like of int
        Those joints, and the place of each one's parent among them.
    first_marker : array-like of int, shape=[B + 1]
        Where the markers of each joint are in `offsets`.
    offsets : array-like, shape=[P, 3]
    targets : array-like, shape=[F, P, 3]
        Where markers should be in the world.
    weights : array-like, shape=[F, B]
        Of the errors of each joint's markers.
    """

    vectors: np.ndarray
    translations: np.ndarray
    scales: np.ndarray
    references: np.ndarray
    plain: np.ndarray
    plain_targets: np.ndarray
    plain_tolerances: np.ndarray
    world: np.ndarray
    locals: np.ndarray
    matrices: np.ndarray
    parents: np.ndarray
    below: np.ndarray
    members: np.ndarray
    member_parents: np.ndarray
    first_marker: np.ndarray
    offsets: np.ndarray
    targets: np.ndarray
    weights: np.ndarray


@inlined
def rotation_of(reference, vector):
    """Return the quaternion of a rotation vector on top of a reference."""
    half = 0.5 * np.sqrt(vectors.dot(vector, vector))
    scale = 0.5 * np.sin(half) / half if half > 0.0 else 0.5
    turn = (scale * vector[0], scale * vector[1], scale * vector[2], np.cos(half))
    return vectors.multiply(reference, turn)


@inlined
def right_jacobian(v, c):
    """Return how the body rotation moves with component c of a rotation vector, column c of the right Jacobian."""
    angle = np.sqrt(vectors.dot(v, v))
    if angle > 1e-4:
        a, b = (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    else:
        a, b = 0.5, 1.0 / 6.0
    e = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
    once = vectors.cross(v, e)
    twice = vectors.cross(v, once)
    return (e[0] - a * once[0] + b * twice[0], e[1] - a * once[1] + b * twice[1], e[2] - a * once[2] + b * twice[2])


@inlined
def compose(left, right, out):
    """Multiply affine matrices, shape=[3, 4]."""
    for i in range(3):
        a, b, c = left[i, 0], left[i, 1], left[i, 2]
        for k in range(4):
            out[i, k] = a * right[0, k] + b * right[1, k] + c * right[2, k]
        out[i, 3] += left[i, 3]


@inlined
def image(m, x, y, z):
    """Apply an affine matrix to a point."""
    return (
        m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3],
        m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3],
        m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3],
    )


@compiled
def set_local(pose, f, joint):
    """Write the matrix of a joint relative to its parent, from its rotation vector and translation."""
    v, t = pose.vectors[f, joint], pose.translations[f, joint]
    r = pose.references[joint]
    q = rotation_of((r[0], r[1], r[2], r[3]), (v[0], v[1], v[2]))
    affine.place_joint(np.eye(3, 4), q, (t[0], t[1], t[2]), pose.scales[f, joint], pose.locals[f, joint])


@compiled
def set_matrix(pose, f, joint):
    """Write the matrix of a joint in the world, from its parent's."""
    parent = pose.parents[joint]
    above = pose.world[f] if parent < 0 else pose.matrices[f, parent]
    compose(above, pose.locals[f, joint], pose.matrices[f, joint])


@compiled
def place_all(pose):
    """Write all matrices."""
    for f in range(len(pose.vectors)):
        for joint in range(len(pose.parents)):
            set_local(pose, f, joint)
            set_matrix(pose, f, joint)


@compiled
def gather(pose, joint, kind, c, tolerance, relative, terms):
    """Sum the eighth powers of errors over tolerance, as polynomials of a move of one component.

    Parameters
    ----------
    pose : Pose
    joint, kind, c : int
        Component c of the joint's rotation vector or translation, by kind.
    tolerance : float
    relative : array-like, shape=[B, 3, 4]
        Room to work in.
    terms : array-like, shape=[9, F]
        Written.
    """
    first, last = pose.below[joint], pose.below[joint + 1]
    factor = 1.0 / tolerance**2
    turned, unscaled = np.empty((3, 4)), np.ones(3)
    offsets, targets = pose.offsets, pose.targets
    for f in range(len(pose.vectors)):
        for k in range(TERMS):
            terms[k, f] = 0.0
        parent = pose.parents[joint]
        above = pose.world[f] if parent < 0 else pose.matrices[f, parent]
        own = pose.matrices[f, joint]
        s = pose.scales[f, joint]
        v, r = pose.vectors[f, joint], pose.references[joint]
        u = right_jacobian((v[0], v[1], v[2]), c)
        # columns of the world's image of the joint's frame, unscaled
        q = rotation_of((r[0], r[1], r[2], r[3]), (v[0], v[1], v[2]))
        affine.place_joint(above, q, (0.0, 0.0, 0.0), unscaled, turned)
        for i in range(last - first):
            d = pose.members[first + i]
            if i == 0:
                for a in range(3):
                    for b in range(4):
                        relative[0, a, b] = 1.0 if a == b else 0.0
            else:
                compose(relative[pose.member_parents[first + i]], pose.locals[f, d], relative[i])
            weight = pose.weights[f, d]
            for p in range(pose.first_marker[d], pose.first_marker[d + 1]):
                x, y, z = image(relative[i], offsets[p, 0], offsets[p, 1], offsets[p, 2])
                ex, ey, ez = image(own, x, y, z)
                ex, ey, ez = ex - targets[f, p, 0], ey - targets[f, p, 1], ez - targets[f, p, 2]
                if kind == ROTATION:
                    w = vectors.cross(u, (s[0] * x, s[1] * y, s[2] * z))
                    dx = turned[0, 0] * w[0] + turned[0, 1] * w[1] + turned[0, 2] * w[2]
                    dy = turned[1, 0] * w[0] + turned[1, 1] * w[1] + turned[1, 2] * w[2]
                    dz = turned[2, 0] * w[0] + turned[2, 1] * w[1] + turned[2, 2] * w[2]
                else:
                    dx, dy, dz = above[0, c], above[1, c], above[2, c]
                q0 = factor * (ex * ex + ey * ey + ez * ez)
                q1 = 2.0 * factor * (ex * dx + ey * dy + ez * dz)
                q2 = factor * (dx * dx + dy * dy + dz * dz)
                add_fourth_power(terms, f, q0, q1, q2, weight)


@inlined
def add_fourth_power(terms, f, q0, q1, q2, weight):
    """Add the fourth power of a quadratic to the polynomial of a frame."""
    a0, a1, a2, a3, a4 = q0 * q0, 2.0 * q0 * q1, q1 * q1 + 2.0 * q0 * q2, 2.0 * q1 * q2, q2 * q2
    wa0, wa1, wa2 = weight * a0, weight * a1, weight * a2
    terms[0, f] += wa0 * a0
    terms[1, f] += 2.0 * wa0 * a1
    terms[2, f] += wa1 * a1 + 2.0 * wa0 * a2
    terms[3, f] += 2.0 * (wa0 * a3 + wa1 * a2)
    terms[4, f] += wa2 * a2 + 2.0 * (wa0 * a4 + wa1 * a3)
    terms[5, f] += 2.0 * (wa1 * a4 + wa2 * a3)
    terms[6, f] += weight * a3 * a3 + 2.0 * wa2 * a4
    terms[7, f] += 2.0 * weight * a3 * a4
    terms[8, f] += weight * a4 * a4


@compiled
def gather_plain(pose, place, c, terms):
    """Do as `gather` for a component of numbers that place nothing."""
    factor = 1.0 / pose.plain_tolerances[place] ** 2
    for f in range(len(pose.plain)):
        for k in range(TERMS):
            terms[k, f] = 0.0
        error = pose.plain[f, place, c] - pose.plain_targets[f, place, c]
        add_fourth_power(terms, f, factor * error * error, 2.0 * factor * error, factor, 1.0)


@inlined
def change(terms, start, values, step):
    """Return how much a move along a basis function, times a step, changes the sum."""
    total = 0.0
    for i in range(len(values)):
        a, f = step * values[i], start + i
        p = terms[8, f]
        for k in range(7, 0, -1):
            p = p * a + terms[k, f]
        total += p * a
    return total


@inlined
def shift(terms, start, values, step):
    """Move along a basis function: expand every polynomial about its new place."""
    for i in range(len(values)):
        a, f = step * values[i], start + i
        for first in range(TERMS - 1):
            for k in range(TERMS - 2, first - 1, -1):
                terms[k, f] += a * terms[k + 1, f]


@inlined
def bits_of(costs, size):
    """Return the estimated bits of an integer's size and sign."""
    if size == 0:
        return costs[0]
    beyond = size - LARGEST
    return costs[min(size, LARGEST)] + 1.0 + (2.0 * np.log2(beyond + 1.0) if beyond > 0 else 0.0)


@inlined
def bits_at(costs, lattice, band, k, group, c, value):
    """Return the estimated bits of a value of an integer, by its row of the costs; of scaling coefficients by steps."""
    if band > 0:
        return bits_of(costs, abs(value))
    q = lattice.integers
    bits = bits_of_step(value - q[k - 1, group, c] if k > 0 else value)
    return bits + bits_of_step(q[k + 1, group, c] - value) if k + 1 < lattice.bands[1] else bits


@inlined
def bits_of_step(step):
    """Return the estimated bits of a step between scaling coefficients."""
    return 1.0 + 1.5 * np.log2(1.0 + abs(step))


@inlined
def statistics_of(table, lattice, band, k, group, c):
    """Return the row of a table, shape=[classes, sizes], for a wavelet."""
    q, bands = lattice.integers, lattice.bands
    expected = expected_in_time(q[:, group, c], bands, band, k)
    expected += expected_beside(q, bands, lattice.parents, band, k, group, c)
    return table[class_of(expected)]


@compiled
def visit(pose, lattice, group, c, tolerance, weight, costs, relative, terms):
    """Try to move each integer of one component; return how many moved."""
    joint, kind = lattice.joints[group], lattice.kinds[group]
    if kind == PLAIN:
        gather_plain(pose, joint, c, terms)
        place = pose.plain
    else:
        gather(pose, joint, kind, c, tolerance, relative, terms)
        place = pose.vectors if kind == ROTATION else pose.translations
    q, bands, pointers = lattice.integers, lattice.bands, lattice.pointers
    moved = 0
    for band in range(len(bands) - 1):
        unit = lattice.units[band, group]
        for k in range(bands[band], bands[band + 1]):
            values = lattice.values[pointers[k] : pointers[k + 1]]
            row = statistics_of(costs, lattice, band, k, group, c) if band else costs[0]
            new = best_move(terms, values, unit, weight, row, lattice, band, k, group, c)
            step = (new - q[k, group, c]) * unit
            if step != 0.0:
                shift(terms, lattice.starts[k], values, step)
                for i in range(len(values)):
                    place[lattice.starts[k] + i, joint, c] += step * values[i]
                q[k, group, c] = new
                moved += 1
    if moved and kind != PLAIN:
        for f in range(len(place)):
            set_local(pose, f, joint)
            set_matrix(pose, f, joint)
    return moved


@compiled
def best_move(terms, values, unit, weight, costs, lattice, band, k, group, c):
    """Return the best of an integer, its two neighbours and zero."""
    start, old = lattice.starts[k], lattice.integers[k, group, c]
    slope = 0.0
    for i in range(len(values)):
        slope += terms[1, start + i] * values[i]
    down = -1 if slope > 0.0 else 1
    inwards = old - 1 if old > 0 else old + 1
    old_bits = bits_at(costs, lattice, band, k, group, c, old)
    best, best_gain = old, 0.0
    for trial in range(3):
        new = old + down if trial == 0 else inwards if trial == 1 else 0
        if new == old or (trial == 1 and old == 0):
            continue
        saved, step = old_bits - bits_at(costs, lattice, band, k, group, c, new), (new - old) * unit
        # the sum is convex: it falls by no more than its slope says
        if saved - weight * slope * step <= best_gain:
            continue
        gain = saved - weight * change(terms, start, values, step)
        if gain > best_gain:
            best, best_gain = new, gain
    return best


@compiled
def recount(lattice, counts):
    """Add the sizes of the wavelets' integers to counts, shape=[CLASSES, LARGEST + 1]."""
    q, bands = lattice.integers, lattice.bands
    for band in range(1, len(bands) - 1):
        for k in range(bands[band], bands[band + 1]):
            for group in range(q.shape[1]):
                for c in range(3):
                    statistics_of(counts, lattice, band, k, group, c)[min(abs(q[k, group, c]), LARGEST)] += 1.0


@compiled
def sweep(pose, lattice, components, is_upwards, tolerance, weight, costs, moved):
    """Visit components, 3 group + component, of joints in ascending order; write how many integers of each moved."""
    relative = np.empty((len(pose.parents), 3, 4))
    terms = np.empty((TERMS, len(pose.vectors)))
    placed = 0
    for n in range(len(components)):
        i = len(components) - 1 - n if is_upwards else n
        group, c = components[i] // 3, components[i] % 3
        if lattice.kinds[group] != PLAIN and not is_upwards:
            # what is above the joint has moved
            for joint in range(placed, lattice.joints[group] + 1):
                for f in range(len(pose.vectors)):
                    set_matrix(pose, f, joint)
            placed = lattice.joints[group]
        moved[i] = visit(pose, lattice, group, c, tolerance, weight, costs, relative, terms)
    place_all(pose)


@compiled
def errors(pose, distances):
    """Write the largest distance of the markers of each joint from their places, shape=[F, B]."""
    offsets, targets = pose.offsets, pose.targets
    for f in range(distances.shape[0]):
        for d in range(distances.shape[1]):
            largest, matrix = 0.0, pose.matrices[f, d]
            for p in range(pose.first_marker[d], pose.first_marker[d + 1]):
                x, y, z = image(matrix, offsets[p, 0], offsets[p, 1], offsets[p, 2])
                x, y, z = x - targets[f, p, 0], y - targets[f, p, 1], z - targets[f, p, 2]
                square = x * x + y * y + z * z
                largest = max(largest, square)
            distances[f, d] = np.sqrt(largest)
