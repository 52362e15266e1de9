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


def test_no_line_is_given_where_it_could_be_wrong() -> None:
    """Multi-line strings may look like keys."""
    assert line_of('text = """\nseed = 1\n"""\nseed = 2\n', ("seed",)) is None
