"""Decisions of rules, events for observers, and names that lead elsewhere."""

import ast
import importlib
from pathlib import Path as File
from typing import Any, get_type_hints

import attrs
import numpy as np
import pytest

import rmfs_commands.testing
import rmfs_commands.validation
import rmfs_core.rule_helpers
import rmfs_core.rule_helpers as offered
import rmfs_core.testing
import rmfs_rules.helpers
from cases import cases
from rmfs_commands.processes import events as of_processes
from rmfs_core import events
from rmfs_core.decisions import JointDecision, Leg, OrderAssignment, Path, PodTrip, SolveReport
from rmfs_core.events import Event, ItemPicked, PodLifted
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import ARGUMENTS
from rmfs_core.scenario.model import RulesSection


def test_any_sequence_will_do() -> None:
    assignments, trips = [OrderAssignment(0, 1)], [PodTrip(2, 1)]
    decision = JointDecision(assignments, (trip for trip in trips))  # type: ignore[arg-type]
    assert decision == JointDecision((OrderAssignment(0, 1),), (PodTrip(2, 1),))
    assignments.append(OrderAssignment(5, 5))
    assert decision.assignments == (OrderAssignment(0, 1),)
    assert Path([Leg(3), Leg(4, 10)]).legs == (Leg(3, 0), Leg(4, 10))  # type: ignore[arg-type]
    legs = (Leg(3), Leg(4, 10))
    path = Path(np.array([(3, 0), (4, 10)]))
    assert (path.legs, repr(path)) == (legs, repr(Path(legs)))
    assert path == Path(legs) == Path(list(legs)) != Path(legs[:1])
    assert hash(path) == hash(Path(legs))
    assert all(type(number) is int for leg in path.legs for number in (leg.to, leg.wait_ticks))
    for values in (np.array([3, 0]), np.array([(3.0, 0.0)]), np.array([(3, 0, 0)])):
        assert not any(isinstance(leg, Leg) for leg in Path(values).legs)
    assert Path(Leg(3)).legs == (Leg(3),)  # type: ignore[arg-type]
    assert JointDecision(7).assignments == (7,)  # type: ignore[arg-type, comparison-overlap]


@cases(
    "values message",
    ({"objective": "4"}, "objective is '4'; expected a number or None"),
    ({"objective": True}, "objective is True; expected a number or None"),
    ({"objective": 10**400}, "objective is 10+; expected a number or None"),
    ({"bound": [3]}, r"bound is \[3\]; expected a number or None"),
    ({"stopped_early": 1}, "'stopped_early' must be <class 'bool'>"),
    ({"status": None}, "'status' must be <class 'str'>"),
)
def test_a_report_has_numbers_in_it(values: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        SolveReport(**({"status": "optimal"} | values))


def test_a_report_need_not_say_more_than_its_status() -> None:
    assert SolveReport("optimal") == SolveReport("optimal", objective=None, bound=None, stopped_early=False)


KINDS = [getattr(module, name) for module in (events, of_processes) for name in module.__all__]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_event_holds_plain_values(kind: type[Event]) -> None:
    """Ids, times, texts and tuples of ids: an event can be kept, written and compared after the run."""
    plain = (int, int | None, str, Role, bool, float, float | None, tuple[int, ...])  # a role is a text
    assert attrs.fields(kind)[0].name == "tick"
    for name, type_ in get_type_hints(kind).items():
        assert type_ in plain, f"{kind.__name__}.{name}"


def test_what_took_time_tells_when_it_began() -> None:
    with_start = [kind for kind in KINDS if "start_tick" in attrs.fields_dict(kind)]
    assert {ItemPicked, PodLifted} <= set(with_start)
    assert all(attrs.fields(kind)[1].name == "start_tick" for kind in with_start)


def test_every_role_has_its_key_its_hook_and_its_label() -> None:
    keys = [field.name for field in attrs.fields(RulesSection)]
    keys.remove("wait_for_stock")
    assert [role.key for role in Role] == keys
    assert {role.hook for role in Role} <= ARGUMENTS.keys()
    assert [role.key for role in Role if role.many] == ["filters", "observers"]
    assert [Role.labelled(role.label) for role in Role] == list(Role)
    assert (f"{Role.POA_PPS}", Role.POA_PPS.label, Role("poa_pps")) == ("poa_pps", "POA+PPS", Role.POA_PPS)
    with pytest.raises(ValueError, match="no role is called 'poa'"):
        Role.labelled("poa")


def test_it_offers_the_functions_themselves() -> None:
    assert set(rmfs_rules.helpers.__all__) <= set(dir(offered))
    assert all(getattr(offered, name) is getattr(rmfs_rules.helpers, name) for name in rmfs_rules.helpers.__all__)
    stub = ast.parse(File(offered.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    assert [ast.unparse(node) for node in stub.body] == ["from rmfs_rules.helpers import *"]
    assert rmfs_core.testing.check_rule is rmfs_commands.testing.check_rule
    for name in ("validate_trace", "Fault"):
        assert getattr(rmfs_core.testing, name) is getattr(rmfs_commands.validation, name)
    for name in ("rmfs_core.testing.worlds", "rmfs_core.rule_helpers.trips"):
        with pytest.raises(ModuleNotFoundError, match=f"No module named '{name}'"):
            importlib.import_module(name)


def test_a_misspelt_function_is_an_error_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match="send_pod"):
        _ = offered.send_pod  # type: ignore[attr-defined]
    with pytest.raises(ImportError):
        exec("from rmfs_core.rule_helpers import send_pod")
