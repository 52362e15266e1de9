"""The result of a run: in memory, and written to files."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from attrs import define, field

from rmfs_core.entrypoints import format_module
from rmfs_core.results.catalogue import Metric, by_heading, show
from rmfs_core.results.files import json_ready, output_folder, staged, to_csv, to_json, write_text
from rmfs_core.scenario import Scenario, scenario_to_dict

RESULT_FILE = "result.json"
Row = dict[str, Any]


def tables() -> Any:
    """Return the module that says what tables a result has, the entry point ``tables`` of the group ``rmfs.formats``.

    It has ``Tables``, an observer with each table's rows as an attribute, and ``TABLE_FILES``, its file and columns.
    """
    return format_module("tables")


@define(eq=False)
class Result:
    """What a run measured.

    Parameters
    ----------
    scenario
        The resolved scenario.
    seed
        Its seed.
    versions
        Version of every distribution that took part, by name; the digest of files beside the scenario that hold rules.
    status
        ``"complete"``; ``"horizon"`` when ``run.until_s`` was reached with orders left; ``"partial"`` when the run
        was interrupted; ``"failed"`` when an error ended it.
    metrics
        Every metric by name; the same on every run of the same scenario, seed and versions. None: not defined (a
        mean over no orders). ``described`` has meanings and units.
    timing
        Wall-clock figures by name, ``hook_s`` with the seconds of each hook.
    orders, visits, periods
        Rows of the tables, as in orders.csv, visits.csv and periods.csv.
    error
        Message of the error that ended a failed run.
    notes
        Sentences on what may be a surprise: why no order is complete, how many orders wait for stock at the end.
    summary
        What observers say of the run as a whole: ``"bottleneck"``, where the orders' time went and what limits the run.
    interrupted
        Whether a keyboard interrupt ended the run. (Not in the files.)
    described
        The metrics that observers describe, by name. (Not in the files.)
    hook_calls
        How often the rules of each hook were asked. (Not in the files.)
    """

    scenario: Scenario
    seed: int
    versions: dict[str, str]
    status: str
    metrics: dict[str, Any]
    timing: dict[str, Any]
    orders: list[Row] = field(factory=list, repr=False)
    visits: list[Row] = field(factory=list, repr=False)
    periods: list[Row] = field(factory=list, repr=False)
    error: str | None = None
    notes: list[str] = field(factory=list)
    summary: dict[str, Any] = field(factory=dict, repr=False)
    interrupted: bool = False
    described: dict[str, Metric] = field(factory=dict, repr=False)
    hook_calls: dict[str, int] = field(factory=dict, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Return the content of result.json: everything but the tables."""
        content: dict[str, Any] = {
            "scenario": json_ready(scenario_to_dict(self.scenario)),
            "seed": self.seed,
            "versions": self.versions,
            "status": self.status,
        }
        if self.error is not None:
            content["error"] = self.error
        if self.notes:
            content["notes"] = self.notes
        if self.summary:
            content["summary"] = json_ready(self.summary)
        return content | {"metrics": self.metrics, "timing": self.timing}

    def _repr_html_(self) -> str:
        """Return status and metrics as tables for a notebook: one for each heading."""
        tables = ""
        for heading, metrics in by_heading(self.metrics, self.described).items():
            head = f'<tr><th colspan="3" style="text-align:left">{escape(heading)}</th></tr>'
            tables += f"<table>{head}{''.join(map(self._row, metrics))}</table>"
        head = f"<b>{escape(self.status)}</b>, seed {escape(str(self.seed))}"
        head += f": {escape(' '.join([self.error or '', *self.notes]).strip())}" if self.error or self.notes else ""
        return f'<div>{head}<div style="display:flex;flex-wrap:wrap;align-items:start;gap:0 2em">{tables}</div></div>'

    def _row(self, metric: Metric) -> str:
        value = self.metrics[metric.name]
        shown = show(metric, value) if isinstance(value, int | float | None) else str(value)
        label, shown, unit = map(
            escape, (metric.label.replace("  ", "\u2003"), shown, metric.unit * (value is not None))
        )
        return (
            f'<tr><td style="text-align:left">{label}</td><td style="text-align:right">{shown}</td><td>{unit}</td></tr>'
        )

    def save(self, folder: str | Path) -> None:
        """Write result.json, orders.csv, visits.csv and periods.csv, all of them or none.

        The folder is made when it is not there; files of an earlier run are replaced.

        Raises
        ------
        InputError
            When the folder is a file, or cannot be written to.
        """
        with staged(output_folder(folder)) as path:
            for name, text in (self.table_files() | {RESULT_FILE: to_json(self.to_dict(), indent=2) + "\n"}).items():
                write_text(path / name, text)

    def table_files(self) -> dict[str, str]:
        """Return the text of each table by the name of its file."""
        given = [(name, columns, getattr(self, table)) for table, (name, columns) in tables().TABLE_FILES.items()]
        return {name: to_csv([*(rows[0] if rows else columns)], rows) for name, columns, rows in given}
