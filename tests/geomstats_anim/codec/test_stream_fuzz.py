"""Streams from strangers, with right checksums: a sentence or motion, never a crash, a hang or memory without bound."""

import resource
import zlib

import motions
import numpy as np
import pytest

from geomstats_anim.codec import ExtraChannel, StreamError, pack, unpack, unpack_channels

SECONDS, BYTES = 10.0, 2**31


def mended(stream):
    """The stream with the checksum that its bytes have."""
    check = (zlib.crc32(stream[6:]) & 0xFFFFFF).to_bytes(3, "little")
    return stream[:1] + check + stream[4:]


def mutated(rng, stream):
    """A stream with bits flipped, bytes replaced, removed, repeated or cut off, most of them near the beginning."""
    data = bytearray(stream)
    for _ in range(rng.integers(1, 4)):
        last = min(len(data), 40) if rng.uniform() < 0.5 else len(data)
        at, kind = int(rng.integers(6, max(last, 7))), rng.integers(5)
        if kind == 0 and at < len(data):
            data[at] ^= 1 << rng.integers(8)
        elif kind == 1 and at < len(data):
            data[at] = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.integers(256)])
        elif kind == 2:
            del data[at : at + int(rng.integers(1, 5))]
        elif kind == 3:
            data[at:at] = rng.bytes(int(rng.integers(1, 8)))
        else:
            del data[max(at, 7) :]
    return mended(bytes(data))


def seeds():
    moving, still = motions.motion(30, scales=True), motions.held(motions.motion(), 30)
    face = {"face": ExtraChannel(motions.waves(np.random.default_rng(0), 30, 4), 0.01)}
    uneven = moving.at_frames([0, 1, 4, 9, 10, 20])
    return [
        (moving.skeleton, pack(moving, 0.01, channels=face, effort="fast")),
        (moving.skeleton, pack(moving, 0.03, segment=0.3, effort="fast")),
        (moving.skeleton, pack(uneven, 0.01, effort="fast")),
        (still.skeleton, pack(still, 0.01, effort="fast")),
    ]


def try_mutations(count, seed):
    rng, cases = np.random.default_rng(seed), seeds()
    refused = 0
    for n in range(count):
        skeleton, stream = cases[n % len(cases)]
        broken = mutated(rng, stream)
        start = resource.getrusage(resource.RUSAGE_SELF)
        try:
            decoded = unpack(broken, skeleton)
            unpack_channels(broken, skeleton)
            assert np.isfinite(decoded.rotations).all() and decoded.n_frames > 0
        except StreamError:
            refused += 1
        end = resource.getrusage(resource.RUSAGE_SELF)
        assert end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime < SECONDS, broken.hex()
        assert 1024 * end.ru_maxrss < BYTES, broken.hex()
    return refused


def test_some_mutations():
    assert 0 < try_mutations(150, 0) < 150


@pytest.mark.slow
def test_many_mutations():
    assert 0 < try_mutations(10_000, 1) < 10_000
