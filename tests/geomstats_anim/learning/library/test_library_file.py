"""Files of libraries: the same library comes back, and what strangers write is refused."""

import io
import json
import zipfile

import numpy as np
import pytest
from gaits import gait, library

from geomstats_anim.interpolation.learned_scheme import Learned
from geomstats_anim.learning.library.storage import dump_library, load_library


@pytest.fixture(scope="module")
def data():
    return dump_library(library())


def rewritten(data, change):
    """Let a function change the dictionary of arrays."""
    arrays = dict(np.load(io.BytesIO(data)))
    change(arrays)
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def with_header(data, change):
    def apply(arrays):
        header = json.loads(arrays["header"].tobytes())
        change(header)
        arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)

    return rewritten(data, apply)


def test_a_library_comes_back_as_it_was(data):
    again = load_library(data)
    assert dump_library(again) == data
    clip = gait(50)
    keys = clip.at_frames(np.arange(0, 80, 8))
    ours, theirs = (Learned(keys, None, each)(clip.times).rotations for each in (library(), again))
    np.testing.assert_array_equal(ours, theirs)


def test_a_model_is_less_than_a_megabyte(data):
    assert len(data) < 1e6 * len(library().models)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda h: h.update(version=99), "version 99"),
        (lambda h: h.update(format="x"), "another format"),
        (lambda h: h.pop("joints"), "no joints"),
        (lambda h: h.update(joints=["a"] * 5000), "no joints"),
        (lambda h: h.update(joints=h["joints"][:-1]), "broken"),
        (lambda h: h.update(parents=[0] * 16), "broken"),
        (lambda h: h.update(vertical=[0.0, 2.0, 0.0]), "unit vector"),
        (lambda h: h.update(vertical="up"), "broken"),
        (lambda h: h.update(usualRotations=[[1.0, 1.0, 0.0, 0.0]] * 16), "unit quaternions"),
        (lambda h: h.update(usualRotations=[[0.0, 0.0, 0.0, 1.0]]), "unit quaternions"),
        (lambda h: h.update(models=7), "broken"),
        (lambda h: h["models"].reverse(), "models of the gaps"),
        (lambda h: h["models"][0].update(gap=9), "models of the gaps"),
        (lambda h: h["models"][0].update(units=[[1.0, 0.0, 0.0]] * 5), "no units"),
        (lambda h: h.pop("provenance"), "provenance"),
        (lambda h: h.update(provenance=3), "broken"),
    ],
)
def test_a_changed_header_is_refused(data, change, words):
    with pytest.raises(ValueError, match=words) as caught:
        load_library(with_header(data, change))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        lambda a: a.pop("4/centres"),
        lambda a: a.update({"4/centres": a["4/centres"][:-1]}),
        lambda a: a.update({"4/weights": a["4/weights"].astype(np.float64)}),
        lambda a: a.update({"4/weights": np.full_like(a["4/weights"], np.nan)}),
        lambda a: a.update({"4/reductions": a["4/reductions"][1:]}),
        lambda a: a.update({f"extra{i}": np.zeros(1, np.float16) for i in range(60)}),
        lambda a: a.pop("header"),
    ],
)
def test_changed_arrays_are_refused(data, change):
    with pytest.raises(ValueError, match="library"):
        load_library(rewritten(data, change))


def test_pickles_are_never_loaded():
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        array = io.BytesIO()
        np.lib.format.write_array(array, np.array([{"a": 1}], dtype=object), allow_pickle=True)
        archive.writestr("header.npy", array.getvalue())
    with pytest.raises(ValueError, match="holds object"):
        load_library(file.getvalue())


def test_a_claim_of_many_numbers_takes_no_memory():
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        array = io.BytesIO()
        np.lib.format.write_array_header_1_0(array, {"descr": "<f2", "fortran_order": False, "shape": (10**15,)})
        archive.writestr("header.npy", array.getvalue())
    with pytest.raises(ValueError, match="another size"):
        load_library(file.getvalue())


def test_whatever_bytes_are_changed_it_is_a_library_or_refused(data):
    rng = np.random.default_rng(0)
    for _ in range(60):
        broken = bytearray(data[: rng.integers(1, len(data))] if rng.random() < 0.3 else data)
        near = rng.integers(0, len(broken)) if rng.random() < 0.5 else max(0, len(broken) - rng.integers(1, 900))
        broken[near : near + 4] = rng.bytes(4)
        try:
            load_library(bytes(broken))
        except ValueError as error:
            assert str(error).startswith("This"), error
