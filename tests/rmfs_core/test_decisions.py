"""What rules return."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rmfs_core.decisions import JointDecision, Leg, OrderAssignment, Path, PodTrip, SolveReport


def test_any_sequence_of_parts_will_do() -> None:
    """Lists, generators and tuples make equal decisions, which nothing changes afterwards."""
    assignments, trips = [OrderAssignment(0, 1)], [PodTrip(2, 1)]
    decision = JointDecision(assignments, (trip for trip in trips))  # type: ignore[arg-type]
    assert decision == JointDecision((OrderAssignment(0, 1),), (PodTrip(2, 1),))
    assignments.append(OrderAssignment(5, 5))
    assert decision.assignments == (OrderAssignment(0, 1),)
    assert Path([Leg(3), Leg(4, 10)]).legs == (Leg(3, 0), Leg(4, 10))  # type: ignore[arg-type]


def test_a_path_may_be_given_as_an_array() -> None:
    """Of ends and waits: it is the same path as its legs make, and an array of anything else is no path."""
    legs = (Leg(3), Leg(4, 10))
    path = Path(np.array([(3, 0), (4, 10)]))
    assert (path.legs, repr(path)) == (legs, repr(Path(legs)))
    assert path == Path(legs) == Path(list(legs)) != Path(legs[:1])
    assert hash(path) == hash(Path(legs))
    assert all(type(number) is int for leg in path.legs for number in (leg.to, leg.wait_ticks))
    for values in (np.array([3, 0]), np.array([(3.0, 0.0)]), np.array([(3, 0, 0)])):
        assert not any(isinstance(leg, Leg) for leg in Path(values).legs)


def test_what_is_no_sequence_is_kept_for_the_check_that_names_it() -> None:
    """The kernel's sentence has the rule in it; a TypeError from in here would not."""
    assert Path(Leg(3)).legs == (Leg(3),)  # type: ignore[arg-type]
    assert JointDecision(7).assignments == (7,)  # type: ignore[arg-type, comparison-overlap]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"objective": "4"}, "objective is '4'; expected a number or None"),
        ({"objective": True}, "objective is True; expected a number or None"),
        ({"bound": [3]}, r"bound is \[3\]; expected a number or None"),
        ({"stopped_early": 1}, "'stopped_early' must be <class 'bool'>"),
        ({"status": None}, "'status' must be <class 'str'>"),
    ],
)
def test_a_report_has_numbers_in_it(values: dict[str, Any], message: str) -> None:
    """What a rule reports ends up in files, so its types are held when it is made."""
    with pytest.raises(TypeError, match=message):
        SolveReport(**({"status": "optimal"} | values))


def test_a_report_may_leave_numbers_out() -> None:
    """Whole numbers and fractions are both numbers."""
    report = SolveReport("stopped", objective=4, bound=3.5, stopped_early=True)
    assert (report.objective, report.bound, report.stopped_early) == (4, 3.5, True)
    assert (SolveReport("optimal").objective, SolveReport("optimal").stopped_early) == (None, False)
