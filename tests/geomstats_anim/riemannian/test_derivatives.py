"""Derivatives by autograd and PyTorch, by poses and by the metric, against differences along the group."""

import numpy as np
import pytest
import samples

from geomstats_anim import MetricParameters
from geomstats_anim import rotations as quat

FRAMEWORKS = ["autograd", "torch"]
N = 4
SIDES = ("left", "right", "right", "left")
STEP = 1e-5


@pytest.fixture(params=FRAMEWORKS)
def functions(request):
    return _functions(request.param)


def _functions(name):
    pytest.importorskip(name)
    if name == "torch":
        from geomstats_anim.riemannian import torch_functions

        return torch_functions
    from geomstats_anim.riemannian import autograd_functions

    return autograd_functions


def gradients(functions, scalar, *arguments):
    """Return the derivatives of a scalar function by all of its arguments."""
    if functions.__name__.endswith("torch_functions"):
        import torch

        tensors = [torch.tensor(argument, dtype=torch.float64, requires_grad=True) for argument in arguments]
        scalar(*tensors).backward()
        return [tensor.grad.numpy() for tensor in tensors]
    import autograd

    return list(autograd.grad(scalar, tuple(range(len(arguments))))(*arguments))


def constant(functions, values):
    if functions.__name__.endswith("torch_functions"):
        import torch

        return torch.tensor(values)
    return values


@pytest.fixture
def problem():
    """Points of a batch of 3, one base point, a tangent vector at it, alpha, beta, axes and weights for scalars."""
    rng = np.random.default_rng(0)
    base = samples.quaternions(rng, N)
    points = quat.multiply(
        np.broadcast_to(base, (3, N, 4)), quat.exp(samples.gaps(rng, 3 * N, 20, 70).reshape(3, N, 3))
    )
    vector = quat.to_matrix(base) @ hat(rng.normal(size=(N, 3)))
    weights = rng.normal(size=(3, N, 3, 3))
    numbers = (np.array([2.0, 0.6, 1.0, 3.0]), np.array([0.5, 1.7, 1.0, 0.4]), rng.normal(size=(N, 3)))
    return quat.to_matrix(points), quat.to_matrix(base), vector, numbers, weights


def hat(vector):
    return -np.cross(np.asarray(vector)[..., None, :], np.eye(3))


def turned(points, direction, step):
    return points @ quat.to_matrix(quat.exp(step * direction))


def along(gradient, points, direction):
    """Return the derivative along the group, of a gradient by matrices."""
    return (gradient * (points @ hat(direction))).sum()


def check(functions, scalar, arguments, rtol=1e-6):
    """Compare all derivatives with differences; the arguments with an axis of matrices are points."""
    rng = np.random.default_rng(1)
    found = gradients(functions, scalar, *arguments)
    for i, (argument, gradient) in enumerate(zip(arguments, found, strict=True)):
        for _ in range(2):
            if argument.ndim >= 3:
                direction = rng.normal(size=(*argument.shape[:-2], 3))
                moved = [turned(argument, direction, s * STEP) for s in (1.0, -1.0)]
                slope = along(gradient, argument, direction)
            else:
                direction = rng.normal(size=argument.shape)
                moved = [argument + s * STEP * direction for s in (1.0, -1.0)]
                slope = (gradient * direction).sum()
            values = [
                float(scalar(*(constant(functions, value) for value in (*arguments[:i], end, *arguments[i + 1 :]))))
                for end in moved
            ]
            expected = (values[0] - values[1]) / (2.0 * STEP)
            assert slope == pytest.approx(expected, rel=rtol, abs=1e-7), i
    return found


def test_log_by_everything(functions, problem):
    points, base, _, numbers, weights = problem
    weights = constant(functions, weights)

    def scalar(*arguments):
        return (weights * functions.log(*arguments, invariance=SIDES)).sum()

    check(functions, scalar, (points, base, *numbers))


def test_exp_by_base_point_and_metric(functions, problem):
    _, base, vector, numbers, weights = problem
    weights, vector = constant(functions, weights[0]), constant(functions, vector)

    def scalar(*arguments):
        return (weights * functions.exp(vector, *arguments, invariance=SIDES)).sum()

    check(functions, scalar, (base, *numbers))


def test_exp_by_tangent_vector(functions, problem):
    _, base, vector, numbers, weights = problem
    weights, base_ = constant(functions, weights[0]), constant(functions, base)

    def scalar(flat):
        vectors = flat.reshape((N, 3, 3))
        return (weights * functions.exp(vectors, base_, *(constant(functions, n) for n in numbers), SIDES)).sum()

    check(functions, scalar, (vector.reshape(N, 9),))


@pytest.mark.parametrize("name", ["squared_dist", "dist"])
def test_distances_by_everything(functions, problem, name):
    points, base, _, numbers, weights = problem
    weights = constant(functions, weights[:, 0, 0, 0])

    def scalar(*arguments):
        return (weights * getattr(functions, name)(*arguments, invariance=SIDES)).sum()

    check(functions, scalar, (points, base, *numbers))

    def by_points(points, base):
        return scalar(points, base, *(constant(functions, number) for number in numbers))

    check(functions, by_points, (points, base))


def test_arrays_of_numpy_are_taken(functions, problem):
    points, base, vector, numbers, _ = problem
    calls = [
        ("exp", (vector, base)),
        ("log", (points, base)),
        ("dist", (points, base)),
        ("geodesic", (base, points, [0.5])),
    ]
    for name, arguments in calls:
        call = getattr(functions, name)
        expected = call(*(constant(functions, argument) for argument in (*arguments, *numbers)), invariance=SIDES)
        np.testing.assert_array_equal(call(*arguments, *numbers, invariance=SIDES), expected)


def test_geodesics_by_everything(functions, problem):
    points, base, _, numbers, weights = problem
    weights = constant(functions, np.stack([weights, 2.0 * weights], axis=1))

    def scalar(base, point, *numbers):
        return (weights * functions.geodesic(base, point, [0.3, 1.7], *numbers, SIDES)).sum()

    check(functions, scalar, (base, points, *numbers))


def test_the_gradient_of_the_distance_has_unit_length(functions, problem):
    """And points away from the base point: the metric's eikonal equation."""
    points, base, _, numbers, _ = problem

    def scalar(points):
        base_, *numbers_ = (constant(functions, value) for value in (base, *numbers))
        return functions.dist(points, base_, *numbers_, SIDES).sum()

    (gradient,) = gradients(functions, scalar, points)
    parameters = MetricParameters(*numbers, SIDES)
    seen = np.where(parameters.is_right[:, None, None], gradient @ points.mT, points.mT @ gradient)
    momentum = np.stack([seen[..., 2, 1] - seen[..., 1, 2], seen[..., 0, 2] - seen[..., 2, 0]], axis=-1)
    momentum = np.concatenate([momentum, (seen[..., 1, 0] - seen[..., 0, 1])[..., None]], axis=-1)
    raised = np.linalg.solve(2.0 * parameters.matrices, momentum[..., None])[..., 0]
    np.testing.assert_allclose((momentum * raised).sum(axis=(-2, -1)), 1.0, rtol=1e-9)


@pytest.mark.parametrize("name", FRAMEWORKS)
def test_second_derivatives_of_the_squared_distance_by_points(name, problem):
    functions = _functions(name)
    points, base, _, numbers, _ = problem
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(2, *points.shape[:-2], 3))

    def at(s, t):
        moved = turned(turned(points, x, s), y, t)
        values = (constant(functions, value) for value in (moved, base, *numbers))
        return float(functions.squared_dist(*values, SIDES).sum())

    h = 1e-3
    expected = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h**2)
    if name == "torch":
        import torch

        s, t = (torch.zeros((), dtype=torch.float64, requires_grad=True) for _ in range(2))
        a, b, p, q = (torch.tensor(value) for value in (hat(x), hat(y), points, base))
        moved = p @ torch.linalg.matrix_exp(s * a) @ torch.linalg.matrix_exp(t * b)
        value = functions.squared_dist(moved, q, *(torch.tensor(number) for number in numbers), SIDES).sum()
        (first,) = torch.autograd.grad(value, s, create_graph=True)
        (second,) = torch.autograd.grad(first, t)
    else:
        import autograd
        import autograd.numpy as anp

        def moved(step, direction):
            # to second order, which is all that counts at 0
            generator = step * hat(direction)
            return anp.eye(3) + generator + 0.5 * generator @ generator

        def value(s, t):
            return anp.sum(functions.squared_dist(points @ moved(s, x) @ moved(t, y), base, *numbers, SIDES))

        second = autograd.grad(lambda t: autograd.grad(value, 0)(0.0, t))(0.0)
    assert float(second) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("name", FRAMEWORKS)
def test_other_second_derivatives_are_refused(name, problem):
    functions = _functions(name)
    points, base, _, numbers, _ = problem
    if name == "torch":
        import torch

        alpha = torch.tensor(numbers[0], requires_grad=True)
        rest = [torch.tensor(value) for value in (points, base, *numbers[1:])]
        value = functions.squared_dist(*rest[:2], alpha, *rest[2:], SIDES).sum()
        (first,) = torch.autograd.grad(value, alpha, create_graph=True)
        with pytest.raises(RuntimeError, match="once_differentiable|not available"):
            first.sum().backward()
        return
    import autograd

    def first(alpha):
        return autograd.grad(lambda a: functions.squared_dist(points, base, a, *numbers[1:], SIDES).sum())(alpha).sum()

    with pytest.raises(NotImplementedError, match="second derivative"):
        autograd.grad(first)(numbers[0])


def test_a_metric_is_learned_by_gradients(functions, problem):
    """Alpha and beta of geodesics are found from poses half way."""
    _, base, _, (alpha, beta, _), _ = problem
    rng = np.random.default_rng(4)
    ends = turned(np.broadcast_to(base, (6, N, 3, 3)), samples.gaps(rng, 6 * N, 60, 110).reshape(6, N, 3), 1.0)
    base, ends = constant(functions, base), constant(functions, ends)
    target = functions.geodesic(base, ends, [0.5], *(constant(functions, n) for n in (alpha, beta)))

    def loss(logs):
        numbers = _exp_of(functions, logs)
        return ((functions.geodesic(base, ends, [0.5], numbers[0], numbers[1]) - target) ** 2).sum()

    from scipy.optimize import minimize

    def value_and_gradient(flat):
        logs = flat.reshape(2, N)
        return float(loss(constant(functions, logs))), gradients(functions, loss, logs)[0].ravel()

    found = minimize(value_and_gradient, np.zeros(2 * N), jac=True, method="BFGS", options={"gtol": 1e-10})
    np.testing.assert_allclose(np.exp(found.x.reshape(2, N)), [alpha, beta], rtol=1e-4)


def _exp_of(functions, values):
    if functions.__name__.endswith("torch_functions"):
        return values.exp()
    import autograd.numpy as anp

    return anp.exp(values)
