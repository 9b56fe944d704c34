"""Numbers as bytes, written by hand and read with bounds, since streams come from strangers."""

from __future__ import annotations

import struct

_TOO_SHORT = "The stream ends too early; it is damaged or cut off."


class StreamError(ValueError):
    """A stream that cannot be read: damaged, of a newer version, or of another skeleton."""


class Writer:
    """Bytes that grow: numbers of any size, seven bits per byte, the lowest first."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def number(self, value: int) -> None:
        """Write a number from 0 on."""
        while value > 0x7F:
            self._bytes.append(0x80 | value & 0x7F)
            value >>= 7
        self._bytes.append(value)

    def signed(self, value: int) -> None:
        """Write a whole number, its sign in the lowest bit."""
        self.number(2 * value if value >= 0 else -2 * value - 1)

    def float32(self, value: float) -> None:
        """Write a number in single precision."""
        self._bytes += struct.pack("<f", value)

    def raw(self, data: bytes) -> None:
        """Write bytes."""
        self._bytes += data

    def block(self, data: bytes) -> None:
        """Write bytes behind their number."""
        self.number(len(data))
        self.raw(data)

    def getvalue(self) -> bytes:
        """Return what was written."""
        return bytes(self._bytes)


class Reader:
    """Reads what `Writer` writes, within bounds.

    Raises
    ------
    StreamError
        In every method, if the stream ends too early or a number is out of bounds.
    """

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def number(self, largest: int) -> int:
        """Read a number from 0 to the largest that is allowed."""
        value, shift = 0, 0
        while True:
            if self._at >= len(self._data):
                raise StreamError(_TOO_SHORT)
            byte = self._data[self._at]
            self._at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if value > largest or shift > 70:
                raise StreamError(f"The stream is damaged: a number in it is beyond {largest}.")
            if byte < 0x80:
                return value

    def signed(self, largest: int) -> int:
        """Read a whole number, of a size of at most the largest that is allowed."""
        value = self.number(2 * largest)
        return value // 2 if value % 2 == 0 else -(value + 1) // 2

    def float32(self) -> float:
        """Read a number in single precision."""
        return float(struct.unpack("<f", self.raw(4))[0])

    def raw(self, count: int) -> bytes:
        """Read a number of bytes."""
        if count > len(self._data) - self._at:
            raise StreamError(_TOO_SHORT)
        self._at += count
        return self._data[self._at - count : self._at]

    def block(self) -> bytes:
        """Read bytes behind their number."""
        return self.raw(self.number(len(self._data)))

    def rest(self) -> bytes:
        """Read all that is left."""
        return self.raw(len(self._data) - self._at)
