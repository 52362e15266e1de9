"""Sessions decide as the simulation does, whatever happens to their process."""

import itertools
import json
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from cases import cases
from driven import Log, Told
from rmfs_commands.results.files import to_json
from rmfs_commands.session import Hall, StaleBatchError
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.hookspecs import hookimpl
from rmfs_core.info import RunInfo
from rmfs_core.results.result import tables
from rmfs_core.scenario import load_scenario

EXAMPLES = Path(__file__).parents[4] / "scenarios" / "examples"


@pytest.fixture(scope="module")
def small() -> Told:
    run = Told(EXAMPLES / "small.toml", ("instance.orders=8",))
    run.run()
    return run


class Rows(tables().Tables):  # type: ignore[misc]
    """Rows of orders.csv and visits.csv of a session, which knows no order before it arrives."""

    def __init__(self, run: Told) -> None:
        super().__init__()
        self._given = run.info.instance

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        super().run_started(evolve(run, instance=self._given))


def hall_of(run: Told, journal: Path | None = None, **options: Any) -> Hall:
    return Hall(run.scenario, journal, **options)


def sent(hall: Hall, run: Told) -> list[dict[str, Any]]:
    return [hall.take(batch) for batch in run.batches()]


@cases(
    "name overrides",
    ("small.toml", ()),
    ("small.toml", ("rules.pp=sipp", "stations.release=picked")),
    ("from-csv.toml", ()),
    ("replenished.toml", ()),
    ("poisson.toml", ("instance.orders=100",)),
)
def test_a_session_decides_what_the_run_decides(name: str, overrides: tuple[str, ...]) -> None:
    run = Told(EXAMPLES / name, overrides)
    run.run()
    log, rows = Log(), Rows(run)
    hall = Hall(run.scenario, observers=lambda: (log, rows))
    answers = sent(hall, run)
    assert [answer["dropped"] for answer in answers if answer["dropped"]] == []
    assert log.rows == run.log.rows
    assert len(log.rows) > 100
    assert rows.orders == run.tables.orders
    assert rows.visits == run.tables.visits
    numbers = [command["command"] for answer in answers for command in answer["commands"]]
    assert numbers == list(range(1, len(numbers) + 1))
