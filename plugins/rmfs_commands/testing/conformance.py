"""The conformance suite: does a rule keep to what every rule promises, in every small world?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import attrs
from attrs import frozen

from rmfs_commands.testing.trial import CallTimes, Outcome, WatchedRule, run_trial
from rmfs_commands.testing.trial_worlds import TrialWorld, trial_worlds
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import check_hooks, require_attrs_class, roles_of
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.wording import counted, listed

RANDOM = "nondeterminism"
KEPT = "state kept"


@frozen
class Finding:
    """Something a rule does that no rule may do.

    Parameters
    ----------
    kind
        ``"impossible decision"``, ``"impossible trace"``, ``"exception"``, ``"starved order"``,
        ``"mutation of the view"``, ``"nondeterminism"`` or ``"state kept"``.
    world
        Name of the trial world where it showed.
    problem
        The finding, in a sentence.
    """

    kind: str
    world: str
    problem: str


@frozen
class ConformanceReport:
    """Findings of the conformance suite on a rule. As a text it is the report for people.

    Parameters
    ----------
    rule
        Name of its class.
    decides
        Kinds of decisions, in the words of `rmfs rules`.
    worlds
        Names of the trial worlds in which it was run.
    left_out
        Name of each trial world that lacks what the rule needs, and what it lacks.
    findings
        Empty for a rule that conforms.
    times
        Number and wall-clock seconds of its calls, by hook. They are no finding: how long is too long depends on the
        warehouse.
    apart
        False for a PP rule without ``reserves``: robots pass through each other, and collisions are not checked.
    """

    rule: str
    decides: tuple[str, ...]
    worlds: tuple[str, ...]
    left_out: Mapping[str, str]
    findings: tuple[Finding, ...]
    times: Mapping[str, CallTimes]
    apart: bool = True

    def __str__(self) -> str:
        lines = [f"{self.rule} decides {listed(self.decides)}; it was run in {len(self.worlds)} small worlds."]
        lines += [f'Left out: "{world}", for it needs {need}.' for world, need in self.left_out.items()]
        lines += [
            f"{hook}: {counted(times.calls, 'call')}, {1000 * times.total_s / times.calls:.3f} ms on average, "
            f"{1000 * times.longest_s:.3f} ms the longest."
            for hook, times in self.times.items()
        ]
        if not self.apart:
            lines.append("Not checked: collisions. It declares no `reserves`, so robots pass through each other.")
        kinds = dict.fromkeys(finding.kind for finding in self.findings)
        lines += [_by_kind(kind, [f for f in self.findings if f.kind == kind]) for kind in kinds]
        return "\n".join(lines if kinds else [*lines, "No findings."])


class ConformanceError(AssertionError):
    """A rule has findings; ``report`` has them all."""

    def __init__(self, report: ConformanceReport) -> None:
        super().__init__(f"{report.rule} does not conform.\n{report}")
        self.report = report


def check_rule(rule: object) -> ConformanceReport:
    """Run a rule in small worlds and fail when it does what no rule may do.

    `trial_worlds` has the worlds, with what each is for; most are tried with unlimited and with finite stock. Those
    that lack what the rule's ``needs`` name are left out; a rule for idle robots that sends none to a charger needs
    ``"no batteries"``. Simple shipped rules take all other decisions; a rule that chooses
    packing stations is tried with one that splits orders. In each world the rule runs three times: twice with the same
    instance, and once with a new one, for which SKUs, orders and pods have other names: these sort as before, but a set
    of them has another order. If the rule plans paths, the robots' movements are validated as by `validate_trace`:
    collisions too where it declares ``reserves``; without, robots pass through each other, and the report says so.

    Parameters
    ----------
    rule
        An instance of the rule's class. Only its parameters are used.

    Returns
    -------
    ConformanceReport
        With the time per call; print it to see it.

    Raises
    ------
    ConformanceError
        An `AssertionError`, when there are findings; its text has them by name.
    InputError
        When it is no rule at all: no attrs class, a misspelt hook, an unknown need.
    """
    __tracebackhide__ = True  # pytest shows the line of the test
    report = conformance_report(rule)
    if report.findings:
        raise ConformanceError(report)
    return report


def conformance_report(rule: object) -> ConformanceReport:
    """Return what `check_rule` finds, without failing.

    Parameters
    ----------
    rule
        An instance of the rule's class. Only its parameters are used.

    Raises
    ------
    InputError
        When it is no rule at all.
    """
    kind = _checked(rule)
    findings: list[Finding] = []
    times: dict[str, CallTimes] = {}
    worlds, left_out = [], {}
    traits = RuleTraits.of(rule, f"class {kind.__name__}", "it")
    able = tuple(role for role in roles_of(kind) if role in traits.decides)
    for world in trial_worlds():
        if lacks := traits.lacks(world.scenario, world.instance):
            left_out[world.name] = lacks[0]
            continue
        worlds.append(world.name)
        for roles in _castings(able):
            findings += _findings(rule, world, roles, times)
    decides = tuple(role.label for role in able)
    apart = Role.PP not in able or traits.reserves is not None
    return ConformanceReport(kind.__name__, decides, tuple(worlds), left_out, tuple(findings), times, apart)


def _checked(rule: object) -> type:
    if isinstance(rule, type):
        raise InputError(f"class {rule.__name__}", f"expected an instance with its parameters: {rule.__name__}(...)")
    kind = type(rule)
    place = f"class {kind.__name__}"
    check_hooks(place, require_attrs_class(place, kind, kind.__name__), kind.__name__)
    if not roles_of(kind):
        raise InputError(place, "it implements no hook; mark the methods that do with @hookimpl")
    return kind


def _castings(roles: tuple[Role, ...]) -> list[tuple[Role, ...]]:
    """Return the roles to play at a time: a rule that decides two things together does not decide them one by one."""
    joint = [role for role in roles if len(role.excludes) > 1]
    if not joint:
        return [roles]
    parts = {part for role in joint for part in role.excludes}
    together = tuple(role for role in roles if role not in parts)
    return [together] if together == roles else [together, tuple(role for role in roles if role not in joint)]


def _findings(rule: Any, world: TrialWorld, roles: tuple[Role, ...], times: dict[str, CallTimes]) -> Iterator[Finding]:
    """Yield what is wrong in one world; where the first run fails there is nothing to compare."""
    watched = WatchedRule(attrs.evolve(rule), times)
    first = run_trial(world, watched, roles)
    for kind, problem in first.problems:
        yield Finding(kind, world.name, problem)
    if first.problems:
        return
    again = run_trial(world, watched, roles)
    fresh = run_trial(world.renamed(), WatchedRule(attrs.evolve(rule), times), roles)
    if differs := _difference(first, fresh):
        problem = "the same world gave another run with a new instance and longer names of SKUs, orders and pods"
        why = "randomness not from rng, a clock, or the order of a set?"
        yield Finding(RANDOM, world.name, f"{problem}: {differs} ({why})")
    elif differs := _difference(first, again):
        yield Finding(KEPT, world.name, f"an instance that had been used before gave another run: {differs}")


def _difference(one: Outcome, other: Outcome) -> str | None:
    """Name the first thing that differs between two runs, or None."""
    for a, b in zip(one.events, other.events, strict=False):
        if a != b:
            return f"first {a}, then {b}"
    if len(one.events) != len(other.events):
        return f"first {len(one.events)} events, then {len(other.events)}"
    kinds, others = ([kind for kind, _ in outcome.problems] for outcome in (one, other))
    return (
        None
        if kinds == others
        else f"first {listed(kinds or ['nothing'])} was wrong, then {listed(others or ['nothing'])}"
    )


def _by_kind(kind: str, findings: list[Finding]) -> str:
    first, *others = findings
    worlds = dict.fromkeys(f'"{finding.world}"' for finding in others if finding.world != first.world)
    also = f" (also in {listed(worlds)})" if worlds else ""
    return f'{kind}, in the world "{first.world}"{also}: {first.problem}'
