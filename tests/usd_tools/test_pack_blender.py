"""Blender opens packed files, with their preview, and unpacked ones, with all samples."""

import numpy as np
import pytest
from blender import blender
from pxr import Usd
from rigs import bits, make_rig, random_rotations, read
from test_blender import quaternions

from geomstats_anim import rotations as quat
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

N, KEYS = 40, 12


@pytest.mark.slow
def test_blender_opens_packed_and_unpacked_files(tmp_path, run):
    source, packed, back = (tmp_path / name for name in ("in.usda", "packed.usdc", "back.usdc"))
    make_rig(source, codes=range(N), rotations=random_rotations(N, 3))
    run("pack", source, "-o", packed, "--tolerance", 1, "--preview", KEYS)
    run("unpack", packed, "-o", back)
    dense = animation_of(read_clip(find_animations(Usd.Stage.Open(str(back)))[0]))
    for path, codes in ((packed, read(packed)[0]), (back, list(range(N)))):
        np.save(tmp_path / "frames.npy", np.array(codes, dtype=np.float64))
        shown = blender("read_usd.py", path, tmp_path / f"{path.stem}.npz", tmp_path / "frames.npy")
        np.testing.assert_allclose(shown["keys"], codes, atol=1e-3)
        place = dict(zip(*read(source if path == packed else back), strict=True))
        wanted = quat.normalize(np.array([place[code] for code in codes], dtype=np.float64))
        assert quat.distance(quaternions(shown["rotations"]), wanted).max() < 1e-4
    assert len(read(packed)[0]) == KEYS and bits(read(packed)[1][:1]) == bits(read(source)[1][:1])
    assert dense.n_frames == N
