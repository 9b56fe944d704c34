"""Geodesics found by other means than the package's, to judge it by.

Three kinds, none of which shares a line with the compiled kernels: Runge-Kutta of order 8 on two different forms of
the equations, the closed form for two equal moments, and the closed form in Jacobi's elliptic functions in 30 digits.
"""

import mpmath
import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

RTOL, ATOL = 2.5e-14, 1e-14


def cross_matrix(vector):
    """Matrices hat(v), shape=[..., 3, 3], of vectors, shape=[..., 3]."""
    return -np.cross(np.asarray(vector)[..., None, :], np.eye(3))


def angle_between(left, right):
    """Angles in radians between rotation matrices, shape=[..., 3, 3], accurate near 0."""
    chord = np.linalg.norm(np.asarray(left) - np.asarray(right), axis=(-2, -1))
    return 2.0 * np.arcsin(np.minimum(chord / np.sqrt(8.0), 1.0))


def _integrate(derivative, initial, times):
    """States, shape=[len(times), *initial.shape], of an autonomous system at increasing times."""

    def flat(_, state):
        return derivative(state.reshape(initial.shape)).ravel()

    solution = solve_ivp(flat, (0.0, times[-1]), initial.ravel(), "DOP853", times, rtol=RTOL, atol=ATOL)
    assert solution.success, solution.message
    return solution.y.T.reshape(len(times), *initial.shape)


def momentum_form(moments, momentum, times=(1.0,)):
    """Integrate g' = g hat(I^-1 g^T m), m constant, from the identity.

    Takes moments and momenta, shape=[n, 3]; gives rotation matrices, shape=[T, n, 3, 3].
    """
    moments, momentum = np.atleast_2d(moments), np.atleast_2d(momentum)

    def derivative(g):
        return g @ cross_matrix(np.einsum("nji,nj->ni", g, momentum) / moments)

    return _integrate(derivative, np.tile(np.eye(3), (len(moments), 1, 1)), np.asarray(times, float))


def velocity_form(matrix, velocity, initial=None, right=False, times=(1.0,)):
    """Integrate Euler's equation of the velocity w beside the pose, for any SPD matrix and either side.

    Left: g' = g hat(w), Z w' = (Z w) x w. Right: g' = hat(w) g, Z w' = -(Z w) x w.
    Takes matrices [n, 3, 3], velocities [n, 3], initial poses [n, 3, 3] and sides [n].
    Gives poses, shape=[T, n, 3, 3], and velocities, shape=[T, n, 3].
    """
    velocity = np.atleast_2d(velocity)
    n = len(velocity)
    matrix = np.broadcast_to(matrix, (n, 3, 3))
    inverse = np.linalg.inv(matrix)
    initial = np.tile(np.eye(3), (n, 1, 1)) if initial is None else initial
    right = np.broadcast_to(right, n)
    sign = np.where(right, -1.0, 1.0)[:, None]

    def derivative(state):
        g, w = state[:, :9].reshape(n, 3, 3), state[:, 9:]
        hat = cross_matrix(w)
        g_rate = np.where(right[:, None, None], hat @ g, g @ hat)
        w_rate = sign * np.einsum("nij,nj->ni", inverse, np.cross(np.einsum("nij,nj->ni", matrix, w), w))
        return np.concatenate([g_rate.reshape(n, 9), w_rate], axis=1)

    state = np.concatenate([initial.reshape(n, 9), velocity], axis=1)
    states = _integrate(derivative, state, np.asarray(times, float))
    return states[..., :9].reshape(len(times), n, 3, 3), states[..., 9:]


def two_equal_moments(moments, momentum, time=1.0):
    """Closed form g(t) = exp(t m / I) exp(t (1/J - 1/I) m_a e_a), where J is the moment that differs, about axis a."""
    a = next(a for a in range(3) if moments[(a + 1) % 3] == moments[(a + 2) % 3])
    equal, odd = moments[(a + 1) % 3], moments[a]
    spin = np.zeros(3)
    spin[a] = (1.0 / odd - 1.0 / equal) * momentum[a]
    precession = Rotation.from_rotvec(time * np.asarray(momentum) / equal)
    return (precession * Rotation.from_rotvec(time * spin)).as_matrix()


def elliptic(moments, momentum, time=1.0, digits=30):
    """Closed form for three different moments, with Jacobi's elliptic functions, in many digits.

    The body momentum is that of van Zon & Schofield, "Numerical implementation of the exact dynamics of free rigid
    bodies", 2007, section 2. The remaining angle is the precession of a body axis p about the momentum,
    phi' = G (2H - M_p^2 / I_p) / (G^2 - M_p^2); p is chosen so that the denominator stays away from 0.
    """
    with mpmath.workdps(digits):
        order = sorted(range(3), key=lambda i: moments[i])
        turn = mpmath.zeros(3)
        for row, column in enumerate(order):
            turn[row, column] = 1
        if mpmath.det(turn) < 0:
            turn = -turn
        pose = turn.T * _sorted_elliptic([mpmath.mpf(moments[i]) for i in order], turn * mpmath.matrix(momentum), time)
        return np.array((pose * turn).tolist(), dtype=float)


def _sorted_elliptic(moments, momentum, time):
    """Closed form for I1 < I2 < I3, as an mpmath matrix."""
    i1, i2, i3 = moments
    m1, m2, m3 = momentum
    energy = m1**2 / i1 + m2**2 / i2 + m3**2 / i3
    square = m1**2 + m2**2 + m3**2
    low, high = square - energy * i1, energy * i3 - square
    about_third = square > energy * i2
    a1, a3 = mpmath.sqrt(i1 * high / (i3 - i1)), mpmath.sqrt(i3 * low / (i3 - i1))
    if about_third:
        side, a2 = mpmath.sign(m3), mpmath.sqrt(i2 * high / (i3 - i2))
        rate = mpmath.sqrt((i3 - i2) * low / (i1 * i2 * i3))
        parameter = (i2 - i1) * high / ((i3 - i2) * low)
        phase = mpmath.atan2(side * m2 / a2, m1 / a1)
    else:
        side, a2 = mpmath.sign(m1), mpmath.sqrt(i2 * low / (i2 - i1))
        rate = mpmath.sqrt((i2 - i1) * high / (i1 * i2 * i3))
        parameter = (i3 - i2) * low / ((i2 - i1) * high)
        phase = mpmath.atan2(side * m2 / a2, m3 / a3)
    start = mpmath.ellipf(phase, parameter)

    def body_momentum(t):
        sn, cn, dn = (mpmath.ellipfun(name, start + rate * t, m=parameter) for name in ("sn", "cn", "dn"))
        if about_third:
            return mpmath.matrix([a1 * cn, side * a2 * sn, side * a3 * dn])
        return mpmath.matrix([side * a1 * dn, side * a2 * sn, a3 * cn])

    # G/I_p dt and, with M_p = A cn, (2H - G^2/I_p) G dt / (G^2 - A^2 cn^2), an incomplete integral of the third kind
    pole, amplitude, moment = (0, a1, i1) if about_third else (2, a3, i3)
    stop = start + rate * time
    n = -(amplitude**2) / (square - amplitude**2)
    integral = mpmath.ellippi(n, _amplitude(stop, parameter), parameter) - mpmath.ellippi(n, phase, parameter)
    length = mpmath.sqrt(square)
    precession = length * time / moment
    precession += length * (energy - square / moment) / (square - amplitude**2) * integral / rate
    before, after = _frame(momentum, pole), _frame(body_momentum(time), pole)
    c, s = mpmath.cos(precession), mpmath.sin(precession)
    return before * mpmath.matrix([[1, 0, 0], [0, c, -s], [0, s, c]]) * after.T


def _amplitude(u, parameter):
    """Jacobi's amplitude, continuous in u."""
    sn, cn = mpmath.ellipfun("sn", u, m=parameter), mpmath.ellipfun("cn", u, m=parameter)
    angle = mpmath.atan2(sn, cn)
    turns = mpmath.nint((u - mpmath.ellipf(angle, parameter)) / (4 * mpmath.ellipk(parameter)))
    return angle + 2 * mpmath.pi * turns


def _frame(momentum, pole):
    """Frame of the momentum's direction and the pole, as columns."""

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def unit(a):
        return [x / mpmath.norm(a) for x in a]

    first = unit(list(momentum))
    second = unit(cross(first, [mpmath.mpf(i == pole) for i in range(3)]))
    return mpmath.matrix([first, second, cross(first, second)]).T
