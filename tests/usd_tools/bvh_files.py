"""BVH files to try things on, and an oracle for all of them that shares no code with the reader."""

import numpy as np
from scipy.spatial.transform import Rotation

from geomstats_anim.kinematics import world_pose
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

MIXED = """HIERARCHY
ROOT Hips
{
  OFFSET 1 2 3
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 10 0
    CHANNELS 6 Yrotation Zposition Xrotation Xposition Zrotation Yposition
    JOINT Head
    {
      OFFSET 0 5 1
      CHANNELS 3 Xrotation Yrotation Zrotation
      End Site
      {
        OFFSET 1 4 -2
      }
    }
    JOINT Arm
    {
      OFFSET 4 3 0
      CHANNELS 1 Yrotation
      End Site
      {
        OFFSET 6 0 0
      }
      End Site
      {
        OFFSET 8 2 0
      }
    }
  }
  JOINT Leg
  {
    OFFSET -1 -8 0
    CHANNELS 2 Zrotation Xrotation
  }
}
MOTION
Frames: {frames}
Frame Time: {time}
{rows}
"""
"""Channels in any mix: positions on a joint that is no root, one rotation, two, and a leaf without an end site."""

CHAIN = """HIERARCHY
ROOT Low
{
  OFFSET 1 2 3
  CHANNELS 6 Zposition Xposition Yposition Yrotation Zrotation Xrotation
  JOINT Middle
  {
    OFFSET 0 4 1
    CHANNELS 6 Xrotation Xposition Zrotation Zposition Yrotation Yposition
    JOINT High
    {
      OFFSET 3 0 0
      CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 1 1 0
      }
    }
  }
}
MOTION
Frames: {frames}
Frame Time: {time}
{rows}
"""
"""What Blender reads too: three rotations a joint, and at most one end site."""

N_CHANNELS = 18


def write_bvh(path, n_frames=5, time="0.0333333", seed=0, text=MIXED):
    """Write a file with random numbers; return its text."""
    rows = np.random.default_rng(seed).uniform(-170, 170, (n_frames, N_CHANNELS))
    lines = "\n".join(" ".join(f"{number:.6f}" for number in row) for row in rows)
    text = text.replace("{frames}", str(n_frames)).replace("{time}", str(time)).replace("{rows}", lines)
    path.write_text(text, encoding="utf-8")
    return text


def placed(text):
    """Names, world positions (F, B, 3) of the joints, and of the means of end sites by name, in the file's unit.

    Word by word and matrix by matrix: scipy's orders of several axes, and quaternions, are left to the reader.
    """
    words = iter(text.split())
    joints, stack, channels = [], [], 0
    for word in words:
        if word in ("ROOT", "JOINT"):
            joints.append({"name": next(words), "parent": stack[-1] if stack else None, "ends": [], "channels": []})
            stack.append(joints[-1])
        elif word == "End":
            stack.append(None)
        elif word == "OFFSET":
            offset = np.array([float(next(words)) for _ in range(3)])
            if stack[-1] is None:
                stack[-2]["ends"].append(offset)
            else:
                stack[-1]["offset"] = offset
        elif word == "CHANNELS":
            names = [next(words) for _ in range(int(next(words)))]
            stack[-1]["channels"] = [(name, channels + i) for i, name in enumerate(names)]
            channels += len(names)
        elif word == "}":
            stack.pop()
        elif word == "Time:":
            break
    next(words)
    rows = np.array([float(word) for word in words]).reshape(-1, channels)
    for joint in joints:
        turn, place = np.tile(np.eye(3), (len(rows), 1, 1)), np.tile(joint["offset"], (len(rows), 1))
        for name, column in joint["channels"]:
            if name.endswith("position"):
                place[:, "XYZ".index(name[0])] = rows[:, column]
            else:
                turn = turn @ Rotation.from_euler(name[0].lower(), rows[:, [column]], degrees=True).as_matrix()
        above = joint["parent"]
        joint["turn"] = turn if above is None else above["turn"] @ turn
        joint["place"] = place if above is None else above["place"] + np.einsum("fij,fj->fi", above["turn"], place)
    ends = {
        joint["name"]: joint["place"] + joint["turn"] @ np.mean(joint["ends"], axis=0)
        for joint in joints
        if joint["ends"]
    }
    return [joint["name"] for joint in joints], np.stack([joint["place"] for joint in joints], axis=1), ends


def clip_of(stage):
    (source,) = find_animations(stage)
    return read_clip(source)


def check_against_oracle(stage, text, scale):
    """Joints and bone ends of a stage are where the numbers of a BVH file put them."""
    names, places, ends = placed(text)
    pose = world_pose(animation_of(clip_of(stage)))
    size = scale * np.abs(places).max()
    np.testing.assert_allclose(pose.origins, scale * places, rtol=0, atol=1e-6 * size)
    for name, end in ends.items():
        np.testing.assert_allclose(pose.ends[:, names.index(name)], scale * end, rtol=0, atol=1e-6 * size)
