"""Rules for every sentence that a verb prints: short, plain, harmless, with short names of joints."""

import re
import unicodedata

LONGEST = 200
"""Characters of a sentence, without the names of files and what is quoted."""

BANNED = (
    r"\bnowhere\b",
    r"\bknows? nothing\b",
    r"\bmakes no\b",
    r"(?<!about )\ba second\b",
    r"\bper seconds\b",
    r"\btells?\b",
    r"\bis said\b",
    r"\bso: ",
    r"\bis written\b",
    r"\bstands? (alone|for)\b",
)

_FULL_JOINTS = re.compile(r"\bhips/spine\b")
"""Of the rigs of these tests, whose last parts are enough."""

_QUOTED = re.compile(r"@[^@]*@|<[^>]*>|'[^']*'|(?:\.{0,2}/)?[\w.\-+~]*/[^\s,;:()]*")
"""The quoted parts of sentences: files, prims, values."""


def broken_rules(printed):
    """List what is wrong with the lines of stdout or stderr; table lines are no sentences."""
    found = []
    for line in printed.splitlines():
        raw = [c for c in line if unicodedata.category(c) in ("Cc", "Cf", "Cs") and c not in "\u200c\u200d"]
        if raw:
            found.append(f"{raw} in {line!r}")
        if not line or line[0] in "│┃┏┡└┌├" or line.startswith(("usage:", " ")):
            continue
        for sentence in re.split(r"(?<=[.?])\s+", _QUOTED.sub("x", line)):
            if len(sentence) > LONGEST:
                found.append(f"{len(sentence)} characters: {sentence}")
            found += [f"{phrase} in {sentence}" for phrase in BANNED if re.search(phrase, sentence)]
        if _FULL_JOINTS.search(line):
            found.append(f"a full path of a joint in {line}")
    return found
