"""Parts of sentences for people: lists, names that may have been meant, errors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from traceback import walk_tb


def listed(names: Iterable[str], last: str = "and") -> str:
    """Names for a sentence: ``a``, ``a and b``, ``a, b and c``; ``nothing`` where there are none."""
    *most, end = [*names] or ["nothing"]
    return f"{', '.join(most)} {last} {end}" if most else end


def counted(number: int, thing: str) -> str:
    """Return a number of things: ``1 station``, ``1,200 stations``."""
    return f"{number:,} {thing}{'' if number == 1 else 's'}"


def first_few(things: Sequence[str]) -> str:
    """Things for a sentence, cut short: ``a, b, c and 7 more``."""
    return listed([*things[:5], f"{len(things) - 5} more"]) if len(things) > 5 else listed(things)


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """Return `` (did you mean `x` or `y`?)`` for the valid names nearest to a misspelt one, else an empty text.

    Where none is near, these are the shortest names that begin with it.
    """
    names = sorted(valid)
    ends = [found for found in names if found.rpartition("/")[2] == name]  # `small` for `examples/small`
    ends = ends or [found for found in names if found.casefold() == name.casefold()]  # `FRACHT` for `fracht`
    begin = sorted((found for found in names if len(name) > 1 and found.startswith(name)), key=len)[:3]
    close = ends or get_close_matches(name, names, n=3, cutoff=0.6) or begin
    return f" (did you mean {listed((f'`{found}`' for found in close), 'or')}?)" if close else ""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the same, or else all the valid names."""
    names = sorted(valid)
    expected = f"; expected one of {', '.join(f'`{found}`' for found in names)}" if names else ""
    return did_you_mean(name, names) or expected


def one_line(error: BaseException) -> str:
    """An exception as one line: its class and its text, if it can say it, without the middle of a long one."""
    try:
        text = " ".join(str(error).split())
    except (Exception, SystemExit):
        text = ""
    text = cut(text, 500)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def raised(error: BaseException, whose: object = None) -> str:
    """Return an error with the line that led to it in the package of ``whose`` author; without one, the last."""
    own = str(getattr(whose, "__module__", "")).partition(".")[0]
    frames = [*walk_tb(error.__traceback__)]
    owned = [one for one in frames if str(one[0].f_globals.get("__name__")).partition(".")[0] == own]
    at = [f" ({frame.f_code.co_filename}, line {line})" for frame, line in (owned or frames)[-1:]]
    return one_line(error) + "".join(at)


def visible(text: str, kept: str = "\n\t\N{NO-BREAK SPACE}") -> str:
    """Return a text whose signs all show: what would steer a terminal or turn the direction is written as in Python."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() or sign in kept else ascii(sign)[1:-1] for sign in text)


LONGEST_VALUE, LONGEST_WORD = 160, 400
"""Signs of a value in quotes, and of a word or path without, that a sentence shows whole."""
_VALUE = re.compile(r"`[^`]*`|\"(?:[^\"\\]|\\.)*\"|(?<!\w)'(?:[^'\\]|\\.)*'(?!\w)|\S+", re.DOTALL)


def shortened(text: str) -> str:
    """Return a text without the middle of each quoted value, or word, that is too long for a sentence."""
    if len(text) <= LONGEST_VALUE:
        return text
    return _VALUE.sub(lambda value: _shortened(value[0]), text)


def _shortened(value: str) -> str:
    return cut(value, LONGEST_VALUE if value[0] in "`\"'" else LONGEST_WORD)


def cut(text: str, most: int) -> str:
    """Return a text without its middle where it is longer than that."""
    return text if len(text) <= most else f"{text[: most * 2 // 3]} ... {text[-most // 4 :]}"


def sentence(text: str) -> str:
    """A message as one line that a terminal can show, whatever it quotes; its middle is left out where it is long."""
    line = visible(" ".join(line.strip() for line in shortened(text).splitlines()), kept="")
    return cut(line, 1200)


def shown_short(value: object) -> str:
    """Any value as one line of at most 80 characters."""
    try:
        return re.sub(r" at 0x[0-9A-Fa-f]+", "", " ".join(repr(value).split()))[:80]  # each run would have another
    except (Exception, SystemExit) as error:  # of a class that cannot say what it is
        return f"a {type(value).__name__}{' with hundreds in one another' * isinstance(error, RecursionError)}"
