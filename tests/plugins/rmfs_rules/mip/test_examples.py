"""The paper's worked examples, with the visits that it counts."""

from __future__ import annotations

import pytest

import rmfs_core


@pytest.mark.parametrize(
    ("example", "visits"),
    [
        ("example-1-integrated", 4),  # Section 1.2: each station takes one order and needs both pods
        ("example-1-split-among-stations", 2),  # one station gets the blue items, the other the orange ones
        ("example-2-integrated", 4),  # Section 2.4: sequential rules need 6
        ("example-appendix", 2),  # Appendix A: either pod comes once
    ],
)
@pytest.mark.parametrize("formulation", ["aggregated", "paper"])
def test_visits(example: str, visits: int, formulation: str) -> None:
    """Either formulation needs as many pod-station visits as the text says."""
    result = rmfs_core.run(f"examples/{example}", overrides=[f"rules.poa_pps.formulation={formulation}"])
    assert result.status == "complete"
    assert result.metrics["pod_station_visits"] == visits


def test_example_2_integrated() -> None:
    """Section 2.4: orders 1 and 2 and pod 3 go to station 1, orders 3 and 4 and pod 4 to station 2; pile-on 3."""
    result = rmfs_core.run("examples/example-2-integrated")
    assert {row["order"]: row["stations"] for row in result.orders} == {"1": "1", "2": "1", "3": "2", "4": "2"}
    assert sorted((row["pod"], row["station"]) for row in result.visits) == [
        ("1", "1"),
        ("2", "2"),
        ("3", "1"),
        ("4", "2"),
    ]
    assert result.metrics["pile_on"] == 3.0
