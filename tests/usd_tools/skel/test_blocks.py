"""Long clips are worked on in blocks, which change nothing."""

import numpy as np
import pytest
from pxr import Usd
from rigs import make_rig, random_rotations

from usd_tools.skel import blocks
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.rotation_checks import count_sign_flips, rotation_steps


@pytest.mark.parametrize("size", [1, 7, 10, 64, 1000])
@pytest.mark.parametrize(("n_joints", "n_frames"), [(1, 1), (5, 2), (5, 23), (100, 3)])
def test_blocks_cover_all_once(monkeypatch, size, n_joints, n_frames):
    monkeypatch.setattr(blocks, "BLOCK", size)
    joints = [joint for part in blocks.joint_blocks(n_joints, n_frames) for joint in range(n_joints)[part]]
    assert joints == list(range(n_joints))
    parts = list(blocks.frame_blocks(n_frames, n_joints))
    gaps = [frame for part in parts for frame in range(part.start, part.stop - 1)]
    assert gaps == list(range(n_frames - 1))
    assert parts[0].start == 0 and parts[-1].stop == n_frames


def test_blocks_change_no_bit(tmp_path, run, monkeypatch):
    rotations = random_rotations(40, 3, size=1.5).astype(float)
    rotations[20:] *= np.where(np.arange(20) % 3, 1.0, -1.0)[:, None, None]
    stage = make_rig(tmp_path / "in.usda", range(40), rotations.astype(np.float32))
    contents, others = [], []
    for size in (1 << 17, 20):
        monkeypatch.setattr(blocks, "BLOCK", size)
        out = tmp_path / "out.usda"
        assert run("upsample", tmp_path / "in.usda", "-o", out, "--factor", 3, "--alpha", 4, "--beta", 0.3)[0] == 0
        contents.append(out.read_bytes())
        clip = read_clip(find_animations(Usd.Stage.Open(stage.GetRootLayer()))[0])
        flips = count_sign_flips(clip.channels["rotations"])
        others.append((clip.cuts.tolist(), rotation_steps(clip).tolist(), flips))
    assert contents[0] == contents[1]
    assert others[0] == others[1] and others[0][2] > 0
