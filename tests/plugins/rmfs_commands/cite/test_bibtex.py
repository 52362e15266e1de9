"""References of docstrings as BibTeX."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.cite.bibtex import references_in, with_own_keys

JOURNAL = """W. E. Smith: Various optimizers. Naval Research
    Quarterly 3(1), 59-66, 1956. https://doi.org/10.1002/n_1 (the idea)"""
ENTRY = """@article{smith1956various,
  author = {W. E. Smith},
  title = {Various optimizers},
  journal = {Naval Research Quarterly},
  volume = {3},
  number = {1},
  pages = {59--66},
  year = {1956},
  doi = {10.1002/n_1},
}
"""


def test_a_journal() -> None:
    """Journal, volume, number and pages are told apart; what comes from it is no part of the entry."""
    (found,) = references_in(JOURNAL)
    assert (found.bibtex(), found.note) == (ENTRY, "the idea")


@pytest.mark.parametrize(
    ("text", "kind", "fields"),
    [
        (
            "L. Xie, H. Li: Efficient methods. arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092",
            "misc",
            {"eprint": "1902.03092", "year": "2019", "url": "https://arxiv.org/abs/1902.03092"},
        ),
        ("H. Ma, S. Koenig: Lifelong planning. AAAI 2019.", "inproceedings", {"booktitle": "AAAI", "year": "2019"}),
        ("J. R. Jackson: Tardiness. Report 43, Los Angeles, 1955.", "misc", {"howpublished": "Report 43, Los Angeles"}),
        ("Found in a drawer. doi: 10.1/a", "misc", {"note": "Found in a drawer. doi: 10.1/a", "doi": "10.1/a"}),
    ],
)
def test_other_kinds(text: str, kind: str, fields: dict[str, str]) -> None:
    """Preprints, conferences, reports; what is written otherwise is a note as a whole."""
    (found,) = references_in(text)
    assert found.kind == kind
    assert {**found.fields, **fields} == found.fields


def test_authors_and_titles_as_styles_want_them() -> None:
    """Authors are joined by "and"; words with capitals inside keep them."""
    (found,) = references_in("M. Merschformann, H. Li: RAWSim-O: a framework. Logistics 11, 8, 2018.")
    assert "  author = {M. Merschformann and H. Li}," in found.bibtex()
    assert "  title = {{RAWSim-O:} a framework}," in found.bibtex()


def test_every_source_once() -> None:
    """The same title is the same source; others that would have its key get a letter."""
    text = "A. Bee: On honey. Hive 1, 2, 2001.\n\nA. Bee: On honey. Hive 1, 2, 2001 (the idea).\n\n"
    found = with_own_keys(references_in(f"{text}A. Bee: On honey and wax. Hive 1, 3, 2001."))
    assert [reference.key for reference in found] == ["bee2001honey", "bee2001honeyb"]


@given(st.text())
def test_any_text_gives_entries(text: str) -> None:
    """Whatever a docstring says, what is printed is BibTeX: braces in pairs, and no line that is none of it."""
    for reference in references_in(text):
        entry = reference.bibtex()  # BibTeX counts braces after a backslash, too
        assert entry.count("{") == entry.count("}")
        assert re.fullmatch(r"@\w+\{\w+,", reference.bibtex().split("\n")[0])
