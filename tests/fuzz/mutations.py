"""Ways to break a file. The same number always breaks it in the same way."""

from __future__ import annotations

import io
import re
import zipfile
from random import Random

NUMBERS = (
    b"nan inf -inf 0 -0 1 -1 1e308 -1e308 1e-320 1e39 65520 1e9 2147483648 18446744073709551616 0.5 7 1e400".split()
)
WORDS = (
    b"def over class SkelAnimation Skeleton SkelRoot Xform uniform custom token[] quatf[] quatd[] float3[] half3[] "
    b"float[] double[] string matrix4d[] rel None ( ) [ ] { } < > , = : @ \" ''' # .timeSamples rotations scales "
    b"translations joints blendShapes restTransforms bindTransforms skel:animationSource prepend apiSchemas active "
    b"instanceable references payload inherits variantSet subLayers offset timeCodesPerSecond metersPerUnit upAxis "
    b"startTimeCode kind </Rig> </Rig/Anim> </World/A> @./nowhere.usda@ clips add delete false true 24 hips hips/ .. "
    b"hips/spine geodesicMetric:alpha geodesicMetric:version HIERARCHY ROOT JOINT End Site OFFSET CHANNELS MOTION "
    b"Frames: Frame Time: Xposition Yposition Zrotation Xrotation \xff \x00 \xc3\xa9"
).split(b" ")
_NUMBER = re.compile(rb"(?<![\w.])-?\d[\d.e+-]*")
_WORD = re.compile(rb"[\w:\[\].]+")


NAMES = (
    "../{}",
    "/{}",
    "a/../../{}",
    "..\\{}",
    "C:\\{}",
    "{}/",
    ".",
    "..",
    "\x1b[2J{}",
    "{}\n",
    "\u202e{}",
    "a" * 300,
    "0.usdc",
)
"""Names of members of packages."""


def renamed(package: bytes, random: Random) -> bytes:
    """Give a member of a package another name."""
    try:
        with zipfile.ZipFile(io.BytesIO(package)) as archive:
            members = [(info.filename, archive.read(info)) for info in archive.infolist()]
    except Exception:  # it is broken already
        return package
    chosen, changed = random.randrange(len(members)), io.BytesIO()
    with zipfile.ZipFile(changed, "w", random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for k, (name, data) in enumerate(members):
            archive.writestr(random.choice(NAMES).format(name) if k == chosen else name, data)
    return changed.getvalue()


def broken(text: bytes, others: list[bytes], is_text: bool, random: Random) -> bytes:
    """Break a file in one to four places."""
    ways = _TEXT if is_text else _BYTES
    for _ in range(random.choice((1, 1, 1, 2, 2, 4))):
        text = random.choice(ways)(text, others, random) or text
    return text


def _replace(
    pattern: re.Pattern[bytes], choices: tuple[bytes, ...] | list[bytes], text: bytes, random: Random
) -> bytes:
    found = list(pattern.finditer(text))
    if not found:
        return text
    at = random.choice(found)
    return text[: at.start()] + random.choice(choices) + text[at.end() :]


def _number(text: bytes, others: list[bytes], random: Random) -> bytes:
    return _replace(_NUMBER, NUMBERS, text, random)


def _word(text: bytes, others: list[bytes], random: Random) -> bytes:
    return _replace(_WORD, WORDS, text, random)


def _own_word(text: bytes, others: list[bytes], random: Random) -> bytes:
    return _replace(_WORD, _WORD.findall(text) or [b""], text, random)


def _insert(text: bytes, others: list[bytes], random: Random) -> bytes:
    at = random.randrange(len(text) + 1)
    return text[:at] + b" " + random.choice(WORDS) + b" " + text[at:]


def _lines(text: bytes, others: list[bytes], random: Random) -> bytes:
    lines = text.split(b"\n")
    a, b = random.randrange(len(lines)), random.randrange(len(lines))
    how = random.randrange(4)
    if how == 0:
        del lines[a]
    elif how == 1:
        lines.insert(b, lines[a])
    elif how == 2:
        lines[a], lines[b] = lines[b], lines[a]
    else:
        del lines[min(a, b) : min(max(a, b), min(a, b) + 8)]
    return b"\n".join(lines)


def _element(text: bytes, others: list[bytes], random: Random) -> bytes:
    """Lose or double an element of an array."""
    found = list(re.finditer(rb"\([^()\n]*\),? ?", text))
    if not found:
        return text
    at = random.choice(found)
    return text[: at.start()] + at.group() * random.choice((0, 0, 2, 3)) + text[at.end() :]


def _bits(text: bytes, others: list[bytes], random: Random) -> bytes:
    data = bytearray(text)
    for _ in range(random.choice((1, 1, 2, 8))):
        if data:
            data[random.randrange(len(data))] = random.choice((0, 255, 127, 128, random.randrange(256)))
    return bytes(data)


def _flip(text: bytes, others: list[bytes], random: Random) -> bytes:
    data = bytearray(text)
    if data:
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return bytes(data)


def _integer(text: bytes, others: list[bytes], random: Random) -> bytes:
    size = random.choice((4, 8))
    at = 8 * random.randrange(max(1, len(text) // 8))
    value = random.choice((0, 1, 2, 255, 1 << 16, 1 << 31, (1 << 32) - 1, len(text), (1 << (8 * size)) - 1))
    return text[:at] + (value % (1 << (8 * size))).to_bytes(size, "little") + text[at + size :]


def _cut(text: bytes, others: list[bytes], random: Random) -> bytes:
    return text[: random.randrange(len(text) + 1)]


def _span(text: bytes, others: list[bytes], random: Random) -> bytes:
    at, length = random.randrange(len(text) + 1), random.choice((1, 2, 8, 64))
    return text[:at] + text[at : at + length] * random.choice((0, 2)) + text[at + length :]


def _splice(text: bytes, others: list[bytes], random: Random) -> bytes:
    other = random.choice(others)
    at = random.randrange(min(len(text), len(other)) + 1)
    return text[:at] + other[at:]


_TEXT = (_number,) * 8 + (_own_word,) * 2 + (_element,) * 4 + (_lines,) * 4 + (_word, _insert, _span, _bits, _cut)
_BYTES = (_bits, _bits, _flip, _flip, _integer, _integer, _span, _cut, _splice)
