"""Two finished runs next to each other: their metrics, and in what they differ."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import asdict, frozen

from rmfs_commands.details.catalogue import MEASURES, METRICS
from rmfs_commands.experiments.report import numbers
from rmfs_commands.instances.overrides import DATA_FILES
from rmfs_commands.results.figures import show
from rmfs_commands.validation.checking import read_result
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE

if TYPE_CHECKING:
    from rich.console import Console

STATE = "instance.state_file"
WORLD = ("seed", "instance", "layout")
"""Keys of a result's scenario that say which orders, pods and stations there are."""


@frozen
class TwoRuns:
    """Two runs.

    Parameters
    ----------
    names
        Their folders.
    ended
        How each ended.
    differs
        Scenario keys and versions that differ, with both values.
    metrics
        Both values of each metric that both have.
    files
        Keys by which both name the same files of orders, pods or stations, and texts that a generator may read as such.
    days
        Names of those that replay the journal of a hall: its orders are not those of the scenario.
    """

    names: tuple[str, str]
    ended: tuple[str, str]
    differs: Mapping[str, tuple[Any, Any]]
    metrics: Mapping[str, tuple[float | None, float | None]]
    files: tuple[str, ...] = ()
    days: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return it for machines."""
        return asdict(self)

    def sentences(self) -> Iterator[str]:
        """Yield how far the runs can be compared."""
        other = [key for key in self.differs if key.partition(".")[0] in WORLD]
        if self.days:
            yield f"{' and '.join(self.days)}: orders are those of a real day; the runs may have different ones."
        elif other:
            yield f"The runs may have other orders, pods or stations, because they differ in {', '.join(other)}."
        elif self.files:
            yield f"Both runs name the same files in {', '.join(self.files)}; their contents are not compared."
        else:
            yield "Both runs have the same orders, pods and stations."
        if set(self.ended) != {"complete"}:
            yield f"They ended as {' and '.join(self.ended)}: figures may be of other orders."
        yield "No test tells whether a difference is chance: `rmfs compare EXPERIMENT` runs several seeds."

    def show(self, console: Console) -> None:
        """Print it."""
        from rich.text import Text

        from rmfs_commands.cli.screen import new_table, print_named, say

        described = {metric.name: metric for group in (*METRICS.values(), MEASURES) for metric in group}
        table = new_table()
        table.add_column("Metric")
        for name in ("First", "Second", "Difference", "Relative"):
            table.add_column(name, justify="right")
        for name, (one, other) in self.metrics.items():
            if (metric := described.get(name)) is None or metric.group is None:  # as in the summary of a run
                continue
            cells = ["", ""]
            if one is not None and other is not None:
                share = f"{numbers.signed(f'{100 * (other / one - 1):,.1f}')} %" if one and metric.unit != "%" else ""
                cells = [numbers.signed(show(metric, other - one)), share]
            label = f"{metric.label} ({metric.unit})" if metric.unit else metric.label
            table.add_row(Text(label), show(metric, one), show(metric, other), *cells)
        for number, name in zip(("First", "Second"), self.names, strict=True):
            say(console, f"{number}: {name}")
        print_named(console, table)
        for key, (one, other) in self.differs.items():
            say(console, f"{key}: {_shown(one)} and {_shown(other)}")
        for sentence in self.sentences():
            say(console, sentence)


def compare_runs(first: str, second: str) -> TwoRuns:
    """Return two runs next to each other.

    Raises
    ------
    InputError
        When a folder has no run.
    """
    results = [_read(folder) for folder in (first, second)]
    flat = [_flat({**one["scenario"], "seed": one["seed"], "versions": one["versions"]}) for one in results]
    keys = dict.fromkeys([*flat[0], *flat[1]])
    pairs = {key: (flat[0].get(key), flat[1].get(key)) for key in keys}
    differs = {key: pair for key, pair in pairs.items() if _plain(key, pair[0]) != _plain(key, pair[1])}
    if (flat[0].get(STATE) is None) != (flat[1].get(STATE) is None):  # what counts begins at the state's time
        differs.pop("run.warmup_s", None)
    files = tuple(key for key, value in flat[0].items() if _names_file(key, value))
    one, other = (result["metrics"] for result in results)
    both = {name: (value, other[name]) for name, value in one.items() if name in other}
    metrics = {name: pair for name, pair in both.items() if all(map(_is_number, pair))}
    days = tuple(name for name, one in zip((first, second), results, strict=True) if "floor" in one.get("summary", {}))
    return TwoRuns((first, second), (results[0]["status"], results[1]["status"]), differs, metrics, files, days)


def _read(folder: str) -> Mapping[str, Any]:
    result = read_result(Path(folder) / RESULT_FILE)
    if result is None:
        raise InputError(folder, f"there is no {RESULT_FILE}; expected the folder of a run")
    kinds = {"scenario": Mapping, "seed": int, "status": str, "versions": Mapping}
    if not all(isinstance(result.get(key), kind) for key, kind in kinds.items()):
        expected = "expected `scenario`, `seed`, `status` and `versions`, as rmfs has written them"
        raise InputError(str(Path(folder) / RESULT_FILE), expected)
    return result


def _names_file(key: str, value: object) -> bool:
    """Whether the value of a scenario's key names, or may name, a file of orders, pods or stations."""
    path = tuple(key.split("."))
    return path[0] in WORLD and isinstance(value, str) and (path in DATA_FILES or "parameters" in path)


def _plain(key: str, value: Any) -> Any:
    """Return a value in one spelling: `2024-03-01` is the midnight `2024-03-01T00:00:00`."""
    if key == "instance.start" and isinstance(value, str):
        with suppress(ValueError):
            return datetime.fromisoformat(value)
    return value


def _is_number(value: object) -> bool:
    return value is None or isinstance(value, int | float)


def _flat(tables: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in tables.items():
        if isinstance(value, Mapping) and "rule" not in value:
            found |= _flat(value, f"{above}{name}.")
        else:
            found[f"{above}{name}"] = value
    return found


def _shown(value: object) -> str:
    return "nothing" if value is None else json.dumps(value)
