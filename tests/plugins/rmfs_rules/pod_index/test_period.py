"""The parameters as compiled code takes them."""

from __future__ import annotations

from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import weights_of
from rmfs_rules.pod_index.period import Stations, Weights


def test_all_numbers_are_of_the_kind_that_was_compiled() -> None:
    """Whole numbers that are given for seconds or shares as well: nothing is compiled for them in a run."""
    whole = weights_of(PodIndex(visit_s=300, finish=1, priority_factor=2, due_factor=1))
    kinds = {name: type(value) for name, value in zip(Weights._fields, weights_of(PodIndex()), strict=True)}
    assert {name: type(value) for name, value in zip(Weights._fields, whole, strict=True)} == kinds
    assert (whole.priority[20], whole.priority[22], whole.least[7]) == (1.0, 4.0, 7.0)
    assert whole.priority.dtype == whole.least.dtype == float


def test_a_station_is_told_of_in_as_many_rows_as_there_are_fields() -> None:
    """Those that `Site.told` makes."""
    assert Stations._fields == ("room", "load", "capacity", "inbound", "counts_orders", "going_on")
