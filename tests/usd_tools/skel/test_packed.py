"""Packed motion from strangers: a sentence or the right motion."""

import base64
import zlib

import numpy as np
import pytest
from pxr import Sdf, Usd, Vt
from rigs import ANIMATION, SKELETON, make_rig, random_rotations, set_samples

from usd_tools.console.errors import ToolError
from usd_tools.pack import PackOptions, pack
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.packed import PACKED

_PREFIX = 6
"""Bytes of version, check and fingerprint."""


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packed")
    make_rig(folder / "in.usda", codes=range(12), rotations=random_rotations(12, 3))
    pack(folder / "in.usda", folder / "out.usda", PackOptions(tolerance=1.0))
    return (folder / "out.usda").read_text()


@pytest.fixture
def stage(packed):
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(packed)
    return Usd.Stage.Open(layer)


def refusal(stage):
    with pytest.raises(ToolError) as caught:
        read_clip(find_animations(stage)[0])
    assert str(caught.value).startswith(f"{ANIMATION}: {PACKED} ")
    return str(caught.value)


def put(stage, kind, value):
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.RemoveProperty(PACKED)
    prim.CreateAttribute(PACKED, kind).Set(value)


def stream_of(stage):
    return base64.b85decode(stage.GetPrimAtPath(ANIMATION).GetAttribute(PACKED).Get())


def test_text_and_bytes_are_the_same_motion(stage):
    before = read_clip(find_animations(stage)[0]).channels["rotations"].values
    stream = np.frombuffer(stream_of(stage), dtype=np.uint8)
    put(stage, Sdf.ValueTypeNames.UCharArray, Vt.UCharArray.FromNumpy(stream))
    assert np.array_equal(read_clip(find_animations(stage)[0]).channels["rotations"].values, before)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (Sdf.ValueTypeNames.String, "not base85 \u00e9"),
        (Sdf.ValueTypeNames.String, "~~~~~"),
        (Sdf.ValueTypeNames.Int, 3),
        (Sdf.ValueTypeNames.IntArray, Vt.IntArray([1, 2])),
        (Sdf.ValueTypeNames.UCharArray, Vt.UCharArray()),
    ],
)
def test_other_values_are_refused(stage, kind, value):
    put(stage, kind, value)
    refusal(stage)


def test_another_skeleton_is_refused(stage):
    matrices = np.array(stage.GetPrimAtPath(SKELETON).GetAttribute("restTransforms").Get())
    matrices[1, 3, 1] += 1.0
    stage.GetPrimAtPath(SKELETON).GetAttribute("restTransforms").Set(Vt.Matrix4dArray.FromNumpy(matrices))
    assert "another skeleton" in refusal(stage)


def test_attributes_that_are_not_held_are_refused(stage):
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.CreateAttribute("blendShapes", Sdf.ValueTypeNames.TokenArray).Set(["smile"])
    prim.CreateAttribute("blendShapeWeights", Sdf.ValueTypeNames.FloatArray).Set(Vt.FloatArray([0.5]), 0.0)
    assert "does not hold blendShapeWeights" in refusal(stage)


def test_without_samples_there_is_no_clock(stage):
    prim = stage.GetPrimAtPath(ANIMATION)
    for name in ("rotations", "translations"):
        prim.GetAttribute(name).Clear()
    refusal(stage)


def test_damage_is_refused_or_harmless(stage):
    rng, stream = np.random.default_rng(0), np.frombuffer(stream_of(stage), dtype=np.uint8)
    before = read_clip(find_animations(stage)[0]).channels["rotations"].values
    for _ in range(100):
        damaged = stream.copy()
        damaged[rng.integers(0, len(stream))] ^= 1 << rng.integers(0, 8)
        put(stage, Sdf.ValueTypeNames.UCharArray, Vt.UCharArray.FromNumpy(damaged[: rng.integers(0, len(stream) + 1)]))
        try:
            after = read_clip(find_animations(stage)[0]).channels["rotations"].values
        except ToolError as error:
            assert PACKED in str(error)
        else:
            assert np.array_equal(before, after)


@pytest.mark.slow
def test_forged_streams_are_refused_or_are_motion(stage):
    """Mutations whose checksum is made right again reach the decoder: a sentence, or finite motion, and soon."""
    rng, stream = np.random.default_rng(1), bytearray(stream_of(stage))
    n_read = 0
    for _ in range(2000):
        forged = bytearray(stream)
        for _ in range(rng.integers(1, 4)):
            forged[rng.integers(_PREFIX, len(forged))] = rng.integers(0, 256)
        forged = forged[: rng.integers(_PREFIX, len(forged) + 1)] if rng.random() < 0.2 else forged
        check = zlib.crc32(forged[_PREFIX:]) & 0xFFFFFF
        forged[1:4] = check.to_bytes(3, "little")
        put(stage, Sdf.ValueTypeNames.UCharArray, Vt.UCharArray.FromNumpy(np.frombuffer(bytes(forged), np.uint8)))
        try:
            clip = read_clip(find_animations(stage)[0])
        except ToolError as error:
            assert str(error).startswith(ANIMATION) and str(error).endswith(".")
        else:
            n_read += 1
            assert all(np.isfinite(channel.values.astype(float)).all() for channel in clip.channels.values())
            assert (np.diff(clip.codes) > 0.0).all()
    assert n_read > 100


def test_new_samples_in_the_same_layer_do_not_break_reading(stage):
    set_samples(stage, "rotations", [5], random_rotations(1, 3, seed=3))
    assert read_clip(find_animations(stage)[0]).codes.tolist() == list(range(12))
