"""Geomstats' own test cases, at tolerances that the stock metric does not reach."""

import geomstats.backend as gs
import numpy as np
import pytest
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.test.data import TestData
from geomstats.test.parametrizers import DataBasedParametrizer
from geomstats.test.random import NFoldManifoldRandomDataGenerator, RandomDataGenerator
from geomstats.test_cases.geometry.invariant_metric import InvariantMetricMatrixTestCase
from geomstats.test_cases.geometry.lie_group import MatrixLieGroupTestCase
from geomstats.test_cases.geometry.nfold_manifold import NFoldManifoldTestCase
from geomstats.test_cases.geometry.riemannian_metric import RiemannianMetricTestCase

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric

ATOL = 1e-8
FULL = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])


@pytest.fixture(autouse=True)
def _seed():
    gs.random.seed(0)


class StrictTestData(TestData):
    # Geomstats' default of three trials passes on one lucky try
    trials = 1

    N_VEC_REPS = [3]
    N_SHAPE_POINTS = [1, 3]
    N_RANDOM_POINTS = [1, 4]
    N_TIME_POINTS = [1, 3]

    def generate_tests(self, test_data, marks=()):
        return super().generate_tests([{"atol": ATOL, **datum} for datum in test_data], marks)


def _data(generate, *names):
    """Make a class that has one method of test data, of one kind, for each name."""
    methods = {f"{name}_test_data": lambda self: getattr(self, generate)() for name in names}
    return type(generate, (StrictTestData,), methods)


class RiemannianMetricTestData(
    _data(
        "generate_random_data",
        "dist_is_symmetric",
        "dist_is_positive",
        "dist_point_to_itself_is_zero",
        "dist_triangle_inequality",
        "dist_is_log_norm",
        "squared_dist_is_symmetric",
        "squared_dist_is_positive",
        "inner_product_is_symmetric",
        "norm_is_positive",
        "normalize_is_unitary",
        "exp_belongs",
        "log_is_tangent",
        "exp_after_log",
        "log_after_exp",
        "exp_geodesic_ivp",
        "geodesic_boundary_points",
        "parallel_transport_ivp_norm",
        "parallel_transport_bvp_norm",
        "parallel_transport_ivp_transported_is_tangent",
        "parallel_transport_bvp_transported_is_tangent",
    ),
    _data(
        "generate_vec_data",
        "exp_vec",
        "log_vec",
        "inner_product_vec",
        "squared_norm_vec",
        "norm_vec",
        "normalize_vec",
        "dist_vec",
        "squared_dist_vec",
        "parallel_transport_ivp_vec",
        "parallel_transport_bvp_vec",
    ),
    _data("generate_vec_data_with_time", "geodesic_ivp_vec", "geodesic_bvp_vec"),
    _data("generate_random_data_with_time", "geodesic_ivp_belongs", "geodesic_bvp_belongs", "geodesic_bvp_reverse"),
):
    pass


class InvariantMetricTestData(
    RiemannianMetricTestData,
    _data("generate_random_data", "invariance", "dual_adjoint_structure_constant", "exp_after_log_at_identity"),
    _data(
        "generate_vec_data",
        "inner_product_at_identity_vec",
        "structure_constant_vec",
        "dual_adjoint_vec",
        "connection_at_identity_vec",
        "connection_vec",
        "curvature_at_identity_vec",
        "curvature_vec",
        "sectional_curvature_at_identity_vec",
        "sectional_curvature_vec",
        "curvature_derivative_at_identity_vec",
        "curvature_derivative_vec",
        "geodesic_equation_vec",
    ),
):
    pass


class BiInvariantMetricTestData(
    InvariantMetricTestData,
    _data("generate_vec_data", "exp_at_identity_vec"),
    _data("generate_random_data", "log_after_exp_at_identity"),
):
    pass


class PoseSpaceTestData(
    _data(
        "generate_random_data",
        "random_point_belongs",
        "random_tangent_vec_is_tangent",
        "to_tangent_is_tangent",
        "regularize_belongs",
        "projection_belongs",
        "compose_with_inverse_is_identity",
        "compose_with_identity_is_itself",
        "exp_after_log",
        "log_after_exp",
    ),
    _data(
        "generate_vec_data",
        "belongs_vec",
        "is_tangent_vec",
        "to_tangent_vec",
        "projection_vec",
        "compose_vec",
        "inverse_vec",
        "exp_vec",
        "log_vec",
        "lie_bracket_vec",
    ),
    _data("generate_shape_data", "random_point_shape", "random_tangent_vec_shape"),
):
    pass


def _so3(matrix, left):
    space = SpecialOrthogonal(3, equip=False)
    return space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=matrix, left=left)


class InvariantMetricCase(InvariantMetricMatrixTestCase):
    tangent_to_multiple = True

    def setup_method(self):
        # short enough to lie before the cut locus
        self.data_generator = RandomDataGenerator(self.space, amplitude=8.0)


class TestDiagonalLeft(InvariantMetricCase, metaclass=DataBasedParametrizer):
    space = _so3(np.diag([1.0, 3.0, 0.4]), True)
    testing_data = InvariantMetricTestData()


class TestDiagonalRight(InvariantMetricCase, metaclass=DataBasedParametrizer):
    space = _so3(np.diag([1.0, 3.0, 0.4]), False)
    testing_data = InvariantMetricTestData()


class TestFullLeft(InvariantMetricCase, metaclass=DataBasedParametrizer):
    space = _so3(FULL, True)
    testing_data = InvariantMetricTestData()


class TestFullRight(InvariantMetricCase, metaclass=DataBasedParametrizer):
    space = _so3(FULL, False)
    testing_data = InvariantMetricTestData()


class TestBiInvariant(InvariantMetricCase, metaclass=DataBasedParametrizer):
    space = _so3(None, True)
    testing_data = BiInvariantMetricTestData()


class PoseMetricCase(RiemannianMetricTestCase):
    tangent_to_multiple = True

    def setup_method(self):
        self.data_generator = RandomDataGenerator(self.space, amplitude=8.0)


class TestPoseMetric(PoseMetricCase, metaclass=DataBasedParametrizer):
    space = PoseSpace(3, equip=False).equip_with_metric(
        PoseMetric,
        parameters=MetricParameters(
            [2.0, 1.0, 5.0],
            [0.5, 1.0, 3.0],
            axes=[[0.1, 0.2, 0.3], [0.0, 0.0, 0.0], [1.0, -0.5, 0.2]],
            invariance=("left", "right", "right"),
        ),
    )
    testing_data = RiemannianMetricTestData()


class TestPoseMetricOneBone(PoseMetricCase, metaclass=DataBasedParametrizer):
    space = PoseSpace(1).equip_with_metric(PoseMetric, parameters=MetricParameters(2.0, 0.5))
    testing_data = RiemannianMetricTestData()


class TestPoseSpace(MatrixLieGroupTestCase, NFoldManifoldTestCase, metaclass=DataBasedParametrizer):
    space = PoseSpace(3)
    testing_data = PoseSpaceTestData()
    tangent_to_multiple = True

    def setup_method(self):
        self.data_generator = NFoldManifoldRandomDataGenerator(self.space)
