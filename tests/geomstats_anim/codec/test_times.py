"""Times: bit for bit, in few bytes where they are even."""

import numpy as np
import pytest

from geomstats_anim.codec.bytestream import Reader, StreamError, Writer
from geomstats_anim.codec.times import read_times, write_times

EVEN = {
    "24": np.arange(100) / 24.0,
    "from a code": (np.arange(1, 200) + 1000) / 30.0,
    "ntsc": np.arange(50) / (24000 / 1001),
    "29.97": np.arange(300) / 29.97,
    "halves": np.arange(0, 40, 0.5) / 24.0,
    "negative": np.arange(-30, 20) / 60.0,
    "one": np.array([2.5]),
    "no": np.zeros(0),
}
UNEVEN = {
    "holes": np.array([0, 1, 2, 5, 6, 20, 21]) / 24.0,
    "any": np.cumsum(np.random.default_rng(0).uniform(0.01, 0.1, 80)),
    "huge": np.array([-1e300, 0.0, 1e300]),
}


def written(times):
    writer = Writer()
    write_times(writer, times)
    return writer.getvalue()


@pytest.mark.parametrize("times", [*EVEN.values(), *UNEVEN.values()], ids=[*EVEN, *UNEVEN])
def test_times_return_bit_for_bit(times):
    reader = Reader(written(times))
    assert read_times(reader, len(times)).tobytes() == times.tobytes()
    assert reader.rest() == b""


@pytest.mark.parametrize("times", EVEN.values(), ids=EVEN)
def test_even_times_take_few_bytes(times):
    assert len(written(times)) <= 10


def test_few_holes_take_few_bytes():
    times = np.delete(np.arange(1000), [10, 500, 501]) / 24.0
    assert len(written(times)) < 50


def test_times_that_do_not_increase_are_refused():
    writer = Writer()
    for number in (0, 24, 1, 0, 0):
        writer.number(number)
    with pytest.raises(StreamError, match="increase"):
        read_times(Reader(writer.getvalue()), 3)
