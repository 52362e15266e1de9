"""XML as it is streamed: values, places, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.import_ import xml_reading
from rmfs_commands.import_.xml_reading import document, elements, root_name
from rmfs_core.errors import InputError

ORDERS = """<?xml version="1.0"?>
<List Type="a">
  <Orders>
    <Order Time="1.5"><Lines><Line SKU="7" /></Lines></Order>
    <Order Time="2" />
  </Orders>
  <Name> some &amp; any </Name>
</List>
"""


def file(folder: Path, text: str | bytes) -> Path:
    """Write a file."""
    path = folder / "orders.xitem"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_elements_come_one_by_one(tmp_path: Path) -> None:
    """With what is in them, their line, and the names of those around them."""
    first, second = elements(file(tmp_path, ORDERS), 2)
    assert (first.name, first.above, first.line, first.number("Time")) == ("Order", ("List", "Orders"), 4, 1.5)
    assert [line.whole("SKU") for line in first.inside[0].inside] == [7]
    assert (second.place, second.inside) == (f"{tmp_path}/orders.xitem, line 5", [])


def test_values_are_attributes_or_elements(tmp_path: Path) -> None:
    """Text without the blanks around it; what is not there has a default, or is asked for."""
    root = document(file(tmp_path, ORDERS))
    assert (root.value("Type"), root.value("Name"), root.value("Other")) == ("a", "some & any", None)
    assert (root.number("Other", 3.5), root.whole("Other", 4), root.truth("Other", True)) == (3.5, 4, True)
    with pytest.raises(InputError, match=r"orders.xitem, line 2: expected a whole number .* of List, found nothing"):
        root.whole("Other")


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ("x", "expected a number from 0 to 10 as `N` of A, found 'x'"),
        ("11", "found '11'"),
        ("NaN", "found 'NaN'"),
        ("1e999", "found '1e999'"),
        ("", "found nothing"),
    ],
)
def test_wrong_numbers_are_told_with_their_line(tmp_path: Path, value: str, problem: str) -> None:
    """The line is that of the element that has the number."""
    root = document(file(tmp_path, f"<A>\n<N>{value}</N></A>"))
    with pytest.raises(InputError) as caught:
        root.number("N", least=0, most=10)
    assert str(caught.value).startswith(f"{tmp_path}/orders.xitem, line 2: ")
    assert problem in str(caught.value)


@pytest.mark.parametrize("value", ["1.0", "-1", "1" * 30, "yes"])
def test_whole_numbers_and_truth_values_are_strict(tmp_path: Path, value: str) -> None:
    """Nothing else is taken for one."""
    root = document(file(tmp_path, f"<A><N>{value}</N></A>"))
    with pytest.raises(InputError, match="expected a whole number"):
        root.whole("N")
    with pytest.raises(InputError, match="expected true or false"):
        root.truth("N", False)


BOMB = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>'


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<a><b></a>", "line 1: this is no valid XML: mismatched tag"),
        ("", "line 1: this is no valid XML: no element found"),
        ("no XML", "line 1: this is no valid XML: syntax error"),
        ('<?xml version="1.0" encoding="klingon"?><a/>', "this is no valid XML: unknown encoding"),
        (BOMB, "found a document type (DOCTYPE); expected none"),
        ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', "found a document type (DOCTYPE); expected none"),
        ("<a>" * 40, "found more than 30 elements in one another; expected fewer"),
    ],
)
def test_what_is_no_such_file_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    """In one sentence; entities are neither expanded nor looked up."""
    with pytest.raises(InputError) as caught:
        document(file(tmp_path, text))
    assert problem in str(caught.value)


def test_there_are_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a record, of what lies between two elements, and of the file."""
    many = "<a><b>" + "<c/>" * 200 + "</b></a>"
    monkeypatch.setattr(xml_reading, "MOST_IN_ONE", 100)
    with pytest.raises(InputError, match="found more than 100 elements and signs in one element"):
        list(elements(file(tmp_path, many), 1))
    assert len(list(elements(file(tmp_path, "<a>" + "<b/>" * 200 + "</a>"), 1))) == 200
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 100)
    with pytest.raises(InputError, match="found more than 100 bytes without an element"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 10**9)
    monkeypatch.setattr(xml_reading, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match="found more than 1,000 bytes"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    """Or is a folder."""
    with pytest.raises(InputError, match=r"none: cannot be read: No such file"):
        document(tmp_path / "none")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        document(tmp_path)


def test_the_outermost_element_is_told_from_the_beginning() -> None:
    """However the rest goes on; nothing for what is no XML."""
    assert root_name(b'\xef\xbb\xbf<?xml version="1.0"?>\n<Instance Name="x"><Bots>') == "Instance"
    assert root_name(b"type octile\n") is None
    assert root_name(b"") is None
