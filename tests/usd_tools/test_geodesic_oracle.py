"""In-betweens of upsampled files against an independent solution of the geodesic equation."""

import numpy as np
import pytest
from pxr import Usd
from real_files import CLIPS, real_file
from rigs import read
from scipy.integrate import solve_ivp

from geomstats_anim import MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import LogStatus, PoseGeodesics
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

FACTOR, MOMENTS = 4, np.array([1.0, 4.0, 0.5])


def integrate(initial, velocity, side):
    """Solve Z w' = (Z w) x w, q' = q w / 2 (left), or Z w' = w x (Z w), q' = w q / 2 (right), from 0 to 1."""

    def rate(_, state):
        q, w = np.split(state.reshape(-1, 7), [4], axis=1)
        turn = np.concatenate([w, np.zeros_like(w[:, :1])], axis=1) / 2.0
        q_rate = quat.multiply(q, turn) if side == "left" else quat.multiply(turn, q)
        torque = np.cross(MOMENTS * w, w) * (1.0 if side == "left" else -1.0)
        return np.concatenate([q_rate, torque / MOMENTS], axis=1).ravel()

    start = np.concatenate([initial, velocity], axis=1).ravel()
    times = np.arange(FACTOR + 1) / FACTOR
    solved = solve_ivp(rate, (0.0, 1.0), start, "DOP853", times, rtol=1e-12, atol=1e-12)
    assert solved.success
    return solved.y.T.reshape(FACTOR + 1, -1, 7)[..., :4]


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("name", [*CLIPS, "usd/mayausd_HIK_Export.usda"])
def test_in_betweens_solve_the_geodesic_equation(tmp_path, run, name, side):
    out = tmp_path / "out.usdc"
    style = ["--alpha", MOMENTS[1], "--beta", MOMENTS[2], "--invariance", side]
    code, _, err = run("upsample", real_file(name), "-o", out, "--factor", FACTOR, "--scheme", "geodesic", *style)
    assert code == 0 and "is slerped" not in err  # no segment fell back

    stage = Usd.Stage.Open(str(real_file(name)))
    clip = read_clip(find_animations(stage)[0])
    keys = quat.normalize(clip.channels["rotations"].values.astype(np.float64))
    n_joints = keys.shape[1]
    parameters = MetricParameters(np.full(n_joints, MOMENTS[1]), np.full(n_joints, MOMENTS[2]), None, side)
    found = PoseGeodesics.between(keys[:-1], keys[1:], parameters)
    assert (found.status == LogStatus.CONVERGED).all()

    solved = integrate(keys[:-1].reshape(-1, 4), found.velocity.reshape(-1, 3), side)
    solved = solved.reshape(FACTOR + 1, len(keys) - 1, n_joints, 4)
    assert quat.distance(quat.normalize(solved[-1]), keys[1:]).max() < 1e-9

    written = quat.normalize(np.array(read(out, prim=clip.path)[1], dtype=np.float64))
    for part in range(1, FACTOR):
        difference = quat.distance(quat.normalize(solved[part]), written[part::FACTOR])
        assert difference.max() < 5e-7  # a float32 quaternion is exact to about 2e-7 rad
