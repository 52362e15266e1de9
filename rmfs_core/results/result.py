"""The result of a run, in memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from attrs import define, field

from rmfs_core.entrypoints import format_module
from rmfs_core.results.catalogue import Metric
from rmfs_core.scenario import Scenario

RESULT_FILE = "result.json"
Row = dict[str, Any]


@define(eq=False)
class Result:
    """Measurements of a run.

    Parameters
    ----------
    scenario
        The resolved scenario.
    seed
        Its seed.
    versions
        Version of every distribution that took part, by name; the digest of files next to the scenario that hold rules.
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
        Observers' findings on the whole run: ``"bottleneck"``, where the orders' time went and what limits the run.
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
        return format_module("results").content(self)  # type: ignore[no-any-return]

    def _repr_html_(self) -> str:
        """Return status and metrics as tables for a notebook: one for each heading."""
        return format_module("results").html(self)  # type: ignore[no-any-return]

    def save(self, folder: str | Path) -> None:
        """Write result.json, orders.csv, visits.csv and periods.csv, all of them or none.

        The folder is made when it is not there; files of an earlier run are replaced.

        Raises
        ------
        InputError
            When the folder is a file, or cannot be written to.
        """
        format_module("results").save(self, folder)
