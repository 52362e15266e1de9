"""The table of metrics at the end of a run."""

from __future__ import annotations

import pytest
from rich.console import Console

import rmfs_core
from rmfs_cli.summary import print_summary
from rmfs_core.results.catalogue import Metric


class Watching:
    """Observer whose metric looks like markup."""

    measures = (Metric("waits", "Waits [s] [/nope]", "[red]", 0),)

    @rmfs_core.hookimpl
    def measured(self) -> dict[str, float | None]:
        """Measure something."""
        return {"waits": 3}


def test_a_label_is_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    """An observer's metric is shown as it is called."""
    result = rmfs_core.run("examples/small", overrides=["instance.orders=2"], observers=[Watching()])
    print_summary(Console(width=100), "small", result)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "Waits" in line]
    assert "Waits [s] [/nope]" in line
    assert "[red]" in line
