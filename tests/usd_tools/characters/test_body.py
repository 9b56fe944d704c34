"""Bodies: skins move as UsdSkel moves them, capsules have their bones inside, and a ray finds the joint it meets."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel
from real_files import real_file
from rigs import make_rig, random_rotations

from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import Body, bounds, capsules, skin
from usd_tools.characters.meshes import triangle_colors, triangles
from usd_tools.characters.placement import placed, up_axis
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

RED, GREEN = [1, 0, 0], [0, 1, 0]


def first_clip(stage):
    return read_clip(find_animations(stage)[0])


def motion_of(clip):
    names = [name for name, channel in clip.channels.items() if channel.is_animated]
    return placed(clip, next(clip.stretches(names)).keys)


@pytest.fixture
def rig(tmp_path):
    clip = first_clip(make_rig(tmp_path / "in.usda", codes=range(6), rotations=random_rotations(6, 3)))
    return clip, motion_of(clip)


@pytest.mark.parametrize("name", ["usd/mayausd_HIK_Export.usda", "usd/usdwg_CesiumMan.usdz"])
def test_skin_is_where_usdskel_puts_it(name):
    path = real_file(name)
    clip = first_clip(open_stage(path))
    animation = motion_of(clip)
    matrices = joint_matrices(animation.at_frames(slice(20, 21)))[0]
    ours = np.concatenate(skin(clip).joined().points(matrices))

    stage = Usd.Stage.Open(str(path))
    UsdSkel.BakeSkinning(stage.Traverse())
    code = clip.codes[20]
    world = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            to_world = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(prim))
            points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get(code), dtype=np.float64)
            world.append(points @ to_world[:3, :3] + to_world[3, :3])
    theirs = np.concatenate(world) * UsdGeom.GetStageMetersPerUnit(stage)
    for each in (np.min, np.max, np.mean):
        np.testing.assert_allclose(each(ours, axis=0), each(theirs, axis=0), atol=2e-4)


def test_capsules_hold_their_bones(rig):
    clip, animation = rig
    body = capsules(animation)
    matrices = joint_matrices(animation)
    (part,) = body.parts
    assert len(np.unique(part.markers.owners)) == clip.skeleton.n_joints
    points = body.points(matrices[3])[0]
    for joint in range(clip.skeleton.n_joints):
        own = points[part.markers.owners == joint]
        origin = matrices[3, joint, :, 3]
        assert (own.min(axis=0) - 1e-9 <= origin).all() and (origin <= own.max(axis=0) + 1e-9).all()


def test_capsules_are_closed_and_face_outwards(rig):
    _, animation = rig
    (part,) = capsules(animation).parts
    edges = np.sort(part.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=-1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    corners = part.markers.places(joint_matrices(animation)[:1])[0][part.faces]
    volume = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert volume > 0.0


def test_a_ray_finds_the_nearest_joint(rig):
    clip, animation = rig
    body, matrices = capsules(animation), joint_matrices(animation)[2]
    (part,), (points,) = body.parts, body.points(matrices)
    for joint in range(clip.skeleton.n_joints):
        middle = points[part.markers.owners == joint].mean(axis=0)
        side = np.cross(middle - matrices[joint, :, 3], [0.3, 0.5, 0.8])
        side /= np.linalg.norm(side)
        assert body.joint_at(matrices, middle + 0.08 * side, -side) == joint
    assert body.joint_at(matrices, np.array([0.0, 0.0, 99.0]), np.array([0.0, 0.0, 1.0])) is None
    assert Body(()).joint_at(matrices, np.zeros(3), np.ones(3)) is None


def test_bounds_hold_every_pose(rig):
    _, animation = rig
    body = capsules(animation)
    low, high = bounds(body, animation)
    every = np.concatenate([body.points(matrices)[0] for matrices in joint_matrices(animation)])
    np.testing.assert_allclose([low, high], [every.min(axis=0), every.max(axis=0)], atol=1e-12)


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


def mesh(stage, orientation="rightHanded", holes=()):
    made = UsdGeom.Mesh.Define(stage, "/Mesh")
    made.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)])
    made.CreateFaceVertexCountsAttr([4, 3])
    made.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 2])
    made.CreateOrientationAttr(orientation)
    made.CreateHoleIndicesAttr(list(holes))
    return made


def test_faces_become_triangles(stage):
    corners, faces = triangles(mesh(stage).GetPrim())
    assert corners.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6]] and faces.tolist() == [0, 0, 1]
    corners, _ = triangles(mesh(stage, "leftHanded", holes=[0]).GetPrim())
    assert corners.tolist() == [[6, 5, 4]]


@pytest.mark.parametrize(
    ("interpolation", "values", "expected"),
    [
        ("constant", [RED], [RED, RED, RED]),
        ("uniform", [RED, GREEN], [RED, RED, GREEN]),
        ("vertex", [RED, GREEN, RED, RED, RED], [RED, RED, GREEN]),
        ("faceVarying", [RED] * 4 + [GREEN] * 3, [RED, RED, GREEN]),
        ("vertex", [RED], None),
    ],
)
def test_colors_of_every_interpolation(stage, interpolation, values, expected):
    made = mesh(stage)
    made.CreateDisplayColorPrimvar(interpolation).Set([tuple(value) for value in values])
    colors = triangle_colors(made.GetPrim(), *triangles(made.GetPrim()))
    assert (None if colors is None else (colors / 255).tolist()) == expected


def test_up_axis_is_the_stages(rig):
    clip, _ = rig
    assert up_axis(clip) == "z"
    UsdGeom.SetStageUpAxis(clip.source.stage, "Y")
    assert up_axis(clip) == "y"
