"""Numbers as bytes: they return, and bounds hold."""

import numpy as np
import pytest

from geomstats_anim.codec.bytestream import Reader, StreamError, Writer

NUMBERS = [0, 1, 127, 128, 300, 2**31, 2**53]


def test_numbers_return():
    writer = Writer()
    for number in NUMBERS:
        writer.number(number)
        writer.signed(-number)
        writer.signed(number)
    writer.block(b"abc")
    writer.float32(0.25)
    writer.raw(b"xyz")
    reader = Reader(writer.getvalue())
    for number in NUMBERS:
        assert [reader.number(2**53), reader.signed(2**53), reader.signed(2**53)] == [number, -number, number]
    assert (reader.block(), reader.float32(), reader.rest()) == (b"abc", 0.25, b"xyz")


@pytest.mark.parametrize("data", [b"", b"\x80", b"\xff" * 20])
def test_broken_numbers_are_refused(data):
    with pytest.raises(StreamError):
        Reader(data).number(100)


def test_numbers_beyond_the_bound_are_refused():
    writer = Writer()
    writer.number(101)
    with pytest.raises(StreamError, match="beyond 100"):
        Reader(writer.getvalue()).number(100)


def test_blocks_longer_than_the_stream_are_refused():
    with pytest.raises(StreamError):
        Reader(bytes([5, 1, 2])).block()


def test_any_bytes_end_in_numbers_or_a_sentence():
    rng = np.random.default_rng(0)
    for _ in range(200):
        reader = Reader(rng.bytes(10))
        try:
            while True:
                assert 0 <= reader.number(2**40) <= 2**40
        except StreamError:
            pass
