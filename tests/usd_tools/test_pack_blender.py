"""Blender opens packed files, with their preview, and unpacked ones, with all samples."""

import numpy as np
import pytest
from blender import blender
from pxr import Usd
from real_files import real_file
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["clips/pitching.usda", "usd/mayausd_HIK_Export.usda"])
def test_blender_opens_a_real_clip_packed_and_unpacked(tmp_path, run, name):
    source, packed, back = real_file(name), tmp_path / "packed.usdc", tmp_path / "back.usdc"
    run("pack", source, "-o", packed, "--tolerance", 0.1, "--effort", "fast", "--preview", KEYS)
    run("unpack", packed, "-o", back)
    for path in (packed, back):
        stage = Usd.Stage.Open(str(path))
        prim = stage.GetPrimAtPath(find_animations(stage)[0].path)
        attribute = prim.GetAttribute("rotations")
        codes = attribute.GetTimeSamples()
        np.save(tmp_path / "frames.npy", np.array(codes))
        shown = blender("read_usd.py", path, tmp_path / f"{path.stem}.npz", tmp_path / "frames.npy")
        np.testing.assert_allclose(shown["keys"], codes, atol=1e-3)
        place = {joint.rpartition("/")[2]: k for k, joint in enumerate(prim.GetAttribute("joints").Get())}
        assert set(shown["names"]) == set(place)
        wanted = quat.normalize(np.array([np.array(attribute.Get(code)) for code in codes], dtype=np.float64))
        in_blenders_order = wanted[:, [place[bone] for bone in shown["names"]]]
        assert quat.distance(quaternions(shown["rotations"]), in_blenders_order).max() < 2e-3
        assert len(codes) == (KEYS if path == packed else len(read_clip(find_animations(stage)[0]).codes))
