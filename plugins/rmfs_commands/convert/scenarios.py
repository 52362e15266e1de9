"""A scenario for orders and pods that were made of tables."""

from __future__ import annotations

from math import ceil, sqrt
from textwrap import fill

from rmfs_core.scenario.tomltext import toml_text


def scenario_of(pods: int, start: str | None = None, learned: str | None = None) -> str:
    """Return a scenario with a block layout that has room for the pods, and a station and eight robots for each 100.

    Parameters
    ----------
    pods
        How many.
    start
        Time 0 in ISO 8601; None: a midnight.
    learned
        What SKUs stand on pods by, for the comment.
    """
    blocks = ceil(pods / 0.85 / 8)
    rows = max(2 * ceil(sqrt(blocks / 2.5) / 2) + 1, 3)
    columns = max(ceil(blocks / rows), 2)
    stations = max(1, min(ceil(pods / 100), (rows - 1) // 2))
    begins = "" if start is None else f'start = "{start}"\n'
    told = "Orders and pods made by `rmfs convert`. The layout, its stations and robots are a guess."
    told += (
        f" {toml_text(learned)[1:-1]}" if learned else ""
    )  # a name of a file may have signs that no comment can have
    comment = fill(
        told, 80, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False, break_long_words=False
    )
    return f"""{comment}

seed = 1

[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
{begins}
[layout]
block_rows = {rows}
block_columns = {columns}
stations_east = {stations}

[robots]
count = {max(4, 8 * stations)}

[stations]
item_capacity = 100

[rules]
poa = "pod-match"
pps = "demand"
"""
