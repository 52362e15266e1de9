"""The paper's figures, as they are kept."""

import pytest

from rmfs_commands.reproduction.paper import Range, load_paper

DIAGRAMS = ("fig:mu_simulationframework", "fig:problemdependencies", "fig:locusBots")
SETTINGS = ("tab:instance", "fig:Layout", "tab:decrules")
FIGURES = (
    *("fig:orderlen", "fig:skus", "fig:podstationvisitsperorder", "fig:distancesperorder", "fig:pileon"),
    *("fig:turnovertime", "fig:comptime_total", "fig:prefiltering", "fig:psv_distance_2000_fil10_8bots"),
)
TABLES = ("tab:reltosimtime", "tab:reltotimeperorder", "tab:rel", "tab:reltosimtime_2000")


def test_every_table_and_figure_of_section_4_is_there() -> None:
    """Each label of the paper's source belongs to one exhibit."""
    labels = [label for exhibit in load_paper().values() for label in exhibit.label.split(", ")]
    assert not {*DIAGRAMS, *SETTINGS, *FIGURES, *TABLES} - set(labels)


def test_a_range_is_taken_as_it_is() -> None:
    """Text such as "20 % to 30 %" fewer."""
    assert load_paper()["pod-station-visits"].range("integrated") == Range(0.70, 0.80)


def test_a_printed_number_is_right_to_half_of_its_last_digit() -> None:
    """0.48 seconds stand for 0.475 to 0.485."""
    found = load_paper()["time-per-order"].range("250", "integrated")
    assert found is not None
    assert (found.low, found.high, found.printed) == (pytest.approx(0.475), pytest.approx(0.485), 0.48)


def test_a_picture_has_no_numbers() -> None:
    """Nor has a figure that the paper does not speak of."""
    assert load_paper()["distances"].range("integrated") is None
    assert load_paper()["pile-on"].range("highest", "integrated") is None
