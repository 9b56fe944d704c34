"""Commands of our verbs in the documentation, and what they print there."""

import re
import shlex
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.rst"))]


def joined(text):
    """Join lines that end in a backslash."""
    return re.sub(r"\\\n\s*", "", text)


def blocks(path, language):
    """Return the code blocks of a page in a language, without their indentation."""
    text = path.read_text("utf-8")
    if path.suffix == ".md":
        return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    found = re.findall(rf"^\.\. code-block:: {language}\n((?:[ ]+:.*\n)*)\n((?:[ ]{{3}}.*\n|\n)+)", text, re.MULTILINE)
    return [re.sub(r"^ {3}", "", body, flags=re.MULTILINE).rstrip() + "\n" for _, body in found]


def words_of(line):
    """Split a line of a shell into the words of each of its commands, without comments."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="&|;<>")
    lexer.whitespace_split = True
    found = [[]]
    for word in lexer:
        if set(word) <= set("&|;"):
            found.append([])
        else:
            found[-1].append(word)
    return found


def call_of(words):
    """Return the verb and its arguments, or None where the command is not one of ours."""
    if words[:1] and Path(words[0]).name == "uvx":
        words = words[3:]
    if words[:1] and Path(words[0]).name == "geomstats-anim":
        return words[1], words[2:]
    if len(words) > 2 and words[1] == "-m" and words[2].startswith("usd_tools."):
        return words[2].removeprefix("usd_tools."), words[3:]
    return None


def lines_of(path):
    """Return the lines of a page that are typed into a shell."""
    typed = [line for block in blocks(path, "bash") for line in joined(block).splitlines()]
    consoles = [line for block in blocks(path, "console") for line in joined(block).splitlines()]
    return typed + [line.removeprefix("$ ") for line in consoles if line.startswith("$ ")]


def calls(path):
    """Return the verb and the arguments of each command of ours on a page."""
    commands = (words for line in lines_of(path) for words in words_of(line))
    return [call for words in commands if (call := call_of(words)) is not None]


def parser_of(verb):
    """Return the parser of a verb."""
    return import_module(f"usd_tools.{verb}").parser()
