"""Messages arrive as they were sent, and what is no message is refused before memory is taken for it."""

import io
import struct

import numpy as np
import pytest

from usd_tools.serving.messages import LARGEST_BODY, MARK, read_message, write_message

HEADER = {"request": "hello", "words": ["ä", 1, None, 0.1]}
ARRAYS = {"b": np.array([[0.1, -0.0], [1e308, 5e-324]]), "a": np.zeros((0, 3)), "one": np.array([2.5])}


def sent(header, arrays):
    stream = io.BytesIO()
    write_message(stream, header, arrays)
    return stream.getvalue()


def test_messages_come_back_bit_for_bit_one_after_the_other():
    stream = io.BytesIO(sent(HEADER, ARRAYS) + sent({}, {}))
    header, arrays = read_message(stream)
    assert header == HEADER and list(arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert arrays[name].shape == array.shape and arrays[name].tobytes() == array.tobytes()
    assert read_message(stream) == ({}, {}) and read_message(stream) is None


@pytest.mark.parametrize("stop", [1, 19, 25, -1])
def test_what_is_cut_off_is_refused(stop):
    with pytest.raises(ValueError, match="cut off"):
        read_message(io.BytesIO(sent(HEADER, ARRAYS)[:stop]))


def made(header, body, mark=MARK, sizes=None):
    sizes = sizes or (len(header), len(body))
    return struct.pack("<4sQQ", mark, *sizes) + header + body


@pytest.mark.parametrize(
    "data, fault",
    [
        (made(b"{}", b"", mark=b"JUNK"), "no message"),
        (made(b"{}", b"", sizes=(2, LARGEST_BODY + 1)), "too large"),
        (made(b"{}", b"", sizes=(1 << 63, 0)), "too large"),
        (made(b"{", b""), "not JSON"),
        (made(b"[" * 100000, b""), "not JSON"),
        (made(b"[]", b""), "no object"),
        (made(b"{}", b""), "no shapes"),
        (made(b'{"arrays": [["a", [2]]]}', bytes(8)), "cut off"),
        (made(b'{"arrays": [["a", [-1]]]}', bytes(8)), "no shapes"),
        (made(b'{"arrays": [["a", [1.0]]]}', bytes(8)), "no shapes"),
        (made(b'{"arrays": [["a", [1073741824, 1073741824, 1073741824]]]}', bytes(8)), "cut off"),
        (made(b'{"arrays": []}', bytes(8)), "no array"),
        (made(b'{"arrays": []}', bytes(7)), "no shapes"),
    ],
)
def test_what_is_no_message_is_refused(data, fault):
    with pytest.raises(ValueError, match=fault):
        read_message(io.BytesIO(data))
