"""The line of a key in a TOML text."""

from __future__ import annotations

import pytest

from rmfs_core.scenario.source import line_of

TEXT = """\
# robots.count = 1
seed = 1
robots.count = 2

[instance]  # data
orders = 3
arrivals = { process = "start" }
pods_at_stations."1" = [
  "1",
]

[ rules . poa ]
rule = "x"
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("seed",), 2),
        (("robots", "count"), 3),  # a dotted key
        (("robots",), 3),  # a table that only a dotted key makes
        (("instance",), 5),
        (("instance", "orders"), 6),
        (("instance", "arrivals", "process"), 7),  # within an inline table: the table's line
        (("instance", "pods_at_stations", "1", 0), 8),  # a quoted key, a list over several lines
        (("rules", "poa", "rule"), 13),  # a header with spaces
        (("rules",), 12),  # a table that only a deeper header makes
        (("instance", "skus"), 5),  # not there: the table it would be in
        (("stations", "pick_s"), None),  # nothing of it there
    ],
)
def test_a_key_is_found(path: tuple[str | int, ...], line: int | None) -> None:
    """The line is that of the key, or of the nearest table around it."""
    assert line_of(TEXT, path) == line


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("sets",), 1),
        (("sets", 0, "name"), 2),
        (("sets", 1), 4),
        (("sets", 1, "name"), 5),
        (("sets", 1, "rules", "poa"), 7),  # a table within the last one before it
        (("sets", 2, "name"), 9),  # not there: its table
        (("others", 0, "name"), 11),
    ],
)
def test_tables_of_a_list_are_told_apart(path: tuple[str | int, ...], line: int) -> None:
    """The first is number 0."""
    text = '[[sets]]\nname = "a"\n\n[[sets]]\nname = "b"\n[sets.rules]\npoa = "x"\n\n[[sets]]\n[[ others ]]\nname = 1\n'
    assert line_of(text, path) == line


def test_no_line_is_given_where_it_could_be_wrong() -> None:
    """Multi-line strings may look like keys."""
    assert line_of('text = """\nseed = 1\n"""\nseed = 2\n', ("seed",)) is None
