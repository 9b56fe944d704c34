"""Entropy coding: integers return, whatever they are, and take about as many bits as they are worth."""

import contextlib
import zlib

import motions
import numpy as np
import pytest

from geomstats_anim.codec import entropy
from geomstats_anim.codec.bytestream import StreamError
from geomstats_anim.codec.lattice import Layout, Steps, new_lattice


def lattice(n_frames=64, n_joints=5, others=0, translations=True):
    layout = Layout.of(motions.rig(n_joints), translations, False, others)
    return new_lattice(layout, Steps(40, 0, (40,) * others), n_frames, with_basis=False)


def returned(filled):
    empty = filled._replace(integers=np.zeros_like(filled.integers))
    entropy.decode(entropy.encode(filled), empty)
    return empty.integers


@pytest.mark.parametrize("n_frames", [1, 2, 3, 4, 7, 64, 129])
@pytest.mark.parametrize("size", [0.0, 0.1, 2.0, 300.0, 1e8])
def test_integers_return(n_frames, size):
    filled = lattice(n_frames, others=2)
    filled.integers[:] = np.rint(size * np.random.default_rng(n_frames).standard_t(1.5, filled.integers.shape)).clip(
        -(2**28), 2**28
    )
    assert (returned(filled) == filled.integers).all()


def test_zeros_take_next_to_nothing():
    assert len(entropy.encode(lattice(1000, 20))) < 16


def test_coin_flips_take_a_bit_each():
    filled = lattice(256, 8, translations=False)
    filled.integers[:] = np.random.default_rng(0).choice([-1, 1], filled.integers.shape)
    assert filled.integers.size / 8 < len(entropy.encode(filled)) < 1.1 * filled.integers.size / 8


def test_sparse_integers_take_their_entropy():
    filled, share = lattice(512, 10, translations=False), 0.03
    rng = np.random.default_rng(0)
    filled.integers[:] = rng.choice([-1, 1], filled.integers.shape) * (rng.uniform(size=filled.integers.shape) < share)
    bits = filled.integers.size * (share - share * np.log2(share) - (1 - share) * np.log2(1 - share))
    assert len(entropy.encode(filled)) < 1.12 * bits / 8


def test_any_bytes_decode_or_end_too_early():
    rng, empty = np.random.default_rng(0), lattice()
    for n in range(40):
        with contextlib.suppress(StreamError):
            entropy.decode(rng.bytes(n), empty._replace(integers=np.zeros_like(empty.integers)))
    with pytest.raises(StreamError, match="too early"):
        entropy.decode(b"\xa7" * 4, lattice(2000, 30))


def test_bytes_are_the_same_everywhere():
    filled = lattice(48, 4)
    place = np.arange(filled.integers.size, dtype=np.int64).reshape(filled.integers.shape)
    filled.integers[:] = np.where(place * 7919 % 97 < 12, place * 31 % 23 - 11, 0)
    assert zlib.crc32(entropy.encode(filled)) == 3690273153
