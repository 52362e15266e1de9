"""The references of docstrings as BibTeX.

A reference is a paragraph of a class's section "References": ``A. Author, B. Author: Title. Where, year. Address``, and
what else there is to say. Where is a journal with volume and pages, a conference, or anything else.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping

from attrs import evolve, frozen

from rmfs_commands.cli.latex import latex_text

_PARTS = re.compile(r"(?P<authors>.+?): (?P<title>.+?)\. (?P<where>.*?),? (?P<year>(?:19|20)\d\d)\b[.:]?(?P<rest>.*)")
_JOURNAL = re.compile(r"(?P<journal>.+) (?P<volume>\d+)(?:\((?P<number>[\d-]+)\))?, (?P<pages>[\d-]+)")
_PREPRINT = re.compile(r"arXiv:(?P<eprint>\d{4}\.\d{4,5})")
_CONFERENCE = re.compile(r"[A-Z]{3,}\S*")
_DOI = re.compile(r"(?:https?://)?(?:dx\.)?doi(?:\.org/|:\s?)(10\.[^\s,;]+)")
_ADDRESS = re.compile(r"https?://\S+")
CORPORATE = "The rmfs authors"
"""An author that is no person: in braces, else styles take its words for names."""
_SMALL = frozenset(["a", "an", "and", "for", "in", "of", "on", "the", "to", "with"])


@frozen
class Reference:
    """A source.

    Parameters
    ----------
    kind
        Of the entry: ``article``, ``inproceedings`` or ``misc``.
    key
        Its key in citations.
    fields
        Values by name, as people write them.
    note
        Note: what the rule takes from it.
    """

    kind: str
    key: str
    fields: Mapping[str, str]
    note: str = ""

    @property
    def title(self) -> str:
        """By which it is known; all that is said of it, where that is not written as others are."""
        return self.fields.get("title") or self.fields["note"]

    def bibtex(self) -> str:
        """Return the entry."""
        lines = [f"  {name} = {{{_value(name, value)}}}," for name, value in self.fields.items() if value]
        return "\n".join([f"@{self.kind}{{{self.key},", *lines, "}", ""])


def references_in(text: str) -> list[Reference]:
    """Return the sources that a section "References" names; one that is not written as others is a note as a whole."""
    return [_reference(" ".join(part.split())) for part in re.split(r"\n\s*\n", text.strip()) if part.strip()]


def with_own_keys(references: Iterable[Reference]) -> list[Reference]:
    """Return every source once; different ones that would have the same key get letters."""
    found: dict[str, Reference] = {}
    for reference in references:
        number, key = 0, reference.key
        while key in found and found[key].title != reference.title:
            number += 1
            key = f"{reference.key}{chr(ord('a') + number)}"
        found.setdefault(key, evolve(reference, key=key))
    return list(found.values())


def _reference(text: str) -> Reference:
    doi = _DOI.search(text)
    link = {"doi": doi[1].rstrip(".")} if doi else {}
    if not link and (address := _ADDRESS.search(text)):
        link = {"url": address[0].rstrip(".")}
    parts = _PARTS.match(_ADDRESS.sub("", text))
    if parts is None:
        words = re.findall(r"[a-z]+", text.lower()) or ["reference"]
        return Reference("misc", "".join(words[:3]), {"note": text, **link})
    kind, where = _where(parts["where"].rstrip(","))
    author = " and ".join(re.split(r", (?=\S)", parts["authors"]))
    note = re.sub(r"^\(([^()]*)\)$", r"\1", parts["rest"].strip(" ."))
    told = {"author": author, "title": parts["title"], **where, "year": parts["year"], **link}
    return Reference(kind, _key(author, parts["year"], parts["title"]), told, note)


def _where(text: str) -> tuple[str, dict[str, str]]:
    if preprint := _PREPRINT.fullmatch(text):
        return "misc", {"eprint": preprint["eprint"], "archiveprefix": "arXiv"}
    if journal := _JOURNAL.fullmatch(text):
        return "article", {name: value for name, value in journal.groupdict().items() if value}
    if _CONFERENCE.fullmatch(text):
        return "inproceedings", {"booktitle": text}
    return "misc", {"howpublished": text}


def _key(author: str, year: str, title: str) -> str:
    """Return a key as bibliographies have it: the first author's last name, the year, the first word that says much."""
    last = re.sub(r"[^A-Za-z]", "", _ascii(author.partition(" and ")[0].rpartition(" ")[2]))
    words = [re.sub(r"[^a-z0-9]", "", _ascii(word).lower()) for word in title.split()]
    return f"{last.lower()}{year}{next((word for word in words if word and word not in _SMALL), '')}"


def _ascii(text: str) -> str:
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode("ascii")


def _value(name: str, value: str) -> str:
    if name in ("doi", "url", "eprint"):
        return value.replace("{", "%7B").replace("}", "%7D").replace("\\", "%5C")
    if name == "author" and value == CORPORATE:
        return f"{{{value}}}"
    if name == "pages":
        return value.replace("-", "--")
    if name == "title":  # styles write titles in small letters, except for what is in braces
        return " ".join(f"{{{latex_text(word)}}}" if _keeps_case(word) else latex_text(word) for word in value.split())
    return latex_text(value)


def _keeps_case(word: str) -> bool:
    return any(sign.isupper() for sign in word[1:])
