"""All that is wrong with a scenario, where a run stops at the first.

Each wrong value is removed or replaced by a valid one, and then the rest is checked. What could be wrong
only because of that is not reported.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from attrs import define, evolve, field

from rmfs_commands.cli.loads import Load, loads
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.instances.csv_files import read_skus
from rmfs_commands.instances.problems import oversize_orders
from rmfs_commands.processes.hours import first_common, hours_of, shifts_of
from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule, RuleSet
from rmfs_core.scenario import Scenario, load_scenario
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.scenario.reading import Given, read_tables
from rmfs_core.scenario.rulenames import is_inline, rule_choices
from rmfs_core.scenario.source import KeyPath, dotted, undotted
from rmfs_core.scenario.structuring import KeyProblem, fields_of, section_class
from rmfs_core.simulation.engine import Simulation
from rmfs_core.simulation.setup import begin, open_warehouse, unmet_needs
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted, first_few, sentence
from rmfs_core.world import Instance, Layout, make_layout
from rmfs_core.world.instance_making import instance_problems, unchecked_instance

ROLES = {role.key: role for role in Role}
MOST_IN_SCENARIO, MOST_IN_FILES = 50, 20
"""Mistakes in a scenario, and in its CSV files, that are named."""


@define
class Checked:
    """Findings of a check.

    Parameters
    ----------
    problems
        Place and problem of each thing that is wrong.
    sizes
        How many of what the scenario has, when nothing is wrong.
    notes
        Notes on valid values that may surprise.
    inline_files
        Files that code was loaded from.
    loads
        The loads, when nothing is wrong.
    """

    problems: list[dict[str, str]] = field(factory=list)
    sizes: dict[str, int] = field(factory=dict)
    notes: list[str] = field(factory=list)
    inline_files: list[str] = field(factory=list)
    loads: list[Load] = field(factory=list)


def check_scenario(path: str, overrides: Sequence[str], seed: int | None, *, allow_inline: bool) -> Checked:
    """Return all that is wrong with a scenario.

    Raises
    ------
    InputError
        When the file cannot be read at all.
    """
    check = _Check(read_tables(path, (), seed), allow_inline)
    check.override(path, overrides, seed)
    scenario = check.structured()
    if scenario is None:
        return check.found
    bound = check.rules(scenario)
    instance, layout = check.instance(scenario), check.layout(scenario)
    if instance is not None:
        check.needs(scenario, instance, bound)
    if instance is not None and layout is not None:
        check.opening(scenario, instance, layout)
        if not check.found.problems:
            check.whole(scenario, instance, layout)
    return check.found


def load_checked(path: str, overrides: Sequence[str], seed: int | None = None) -> Scenario:
    """Return a scenario, as `load_scenario` does; of several wrong overrides all but the last are said right away."""
    try:
        return load_scenario(path, overrides, seed)
    except InputError as error:
        if not error.place.startswith("--set "):
            raise
        check = _Check(read_tables(path, (), seed), allow_inline=False)
        check.override(path, overrides, seed)
        check.structured()
        *others, last = [one for one in check.found.problems if one["place"].startswith("--set ")]
        for one in others:
            click.echo(sentence(f"Error: {one['place']}: {one['problem']}"), err=True)
        raise InputError(last["place"], last["problem"]) from error


class _Check:
    """One check: what was found so far, and the replacements for wrong values."""

    def __init__(self, given: Given, allow_inline: bool) -> None:
        self.given = given
        self.allow_inline = allow_inline
        self.found = Checked()
        self.replaced: set[KeyPath] = set()
        self.doubtful: set[KeyPath] = set()

    def note(self, place: str, problem: str) -> bool:
        """Add a problem, its place a key or what a message names; return whether it is new."""
        path = undotted(place)
        return self._add(self.given.source.place_of(path) if path[0] in fields_of(Scenario) else place, problem)

    def _add(self, place: str, problem: str) -> bool:
        entry = {"place": place, "problem": problem}
        new = entry not in self.found.problems
        if new:
            self.found.problems.append(entry)
        return new

    def override(self, path: str, overrides: Sequence[str], seed: int | None) -> None:
        """Apply the overrides that can be applied."""
        good: list[str] = []
        for one in overrides:
            try:
                self.given = read_tables(path, [*good, one], seed)
                good.append(one)
            except InputError as error:
                self.note(error.place, error.problem)

    def structured(self) -> Scenario | None:
        """Return the scenario without what is wrong in it; None if nothing is left of it."""
        while True:
            try:
                return self.given.scenario()
            except KeyProblem as problem:
                path = problem.path
                # What does not go together in a table may do so once its wrong values are mended; and they are there.
                if path not in self.doubtful:
                    new = self._add(self.given.source.place_of(path), problem.problem)
                    if not new:
                        return None
                    if len(self.found.problems) >= MOST_IN_SCENARIO:
                        self._add(self.given.source.name, f"is checked no farther after {MOST_IN_SCENARIO} mistakes")
                        return None
                mended = self._mended(dict(self.given.data), path, problem.problem)
                while mended == self.given.data:  # a part is missing, so what it is part of goes
                    path = path[:-1]
                    if not path:
                        return None
                    mended = self._mended(dict(self.given.data), path, problem.problem)
                self.given = evolve(self.given, data=mended)

    def _mended(self, data: dict[str, Any], path: KeyPath, problem: str) -> dict[str, Any]:
        """Return the tables without what is wrong, or with a rule that stands in for a wrong one."""
        if not path:  # of all sections together: bundles come, and no rules decide on them
            return _without(data, ["instance", "replenishment"])
        section = str(path[0])
        if section == "rules":
            given = data.get("rules")
            return {**data, "rules": self._mended_rules(dict(given) if isinstance(given, Mapping) else {}, path)}
        names = [part for part in path if isinstance(part, str)]
        cls = section_class(Scenario, section) if section in fields_of(Scenario) else None
        if len(names) > 1 and cls is not None and names[1] in fields_of(cls):
            self.doubtful |= {tuple(names[:depth]) for depth in range(1, len(names) + 1)}
        table = data.get(section)
        if len(names) == 1 and cls is not None and isinstance(table, Mapping):
            # Values that exclude each other: the sentence names them.
            named = {key for key in table if re.search(rf"\b{re.escape(key)}\b", problem)}
            return {**data, section: {key: value for key, value in table.items() if key not in (named or table)}}
        return _without(data, names)

    def _mended_rules(self, rules: dict[str, Any], path: KeyPath) -> dict[str, Any]:
        stand_in = next(iter(entrypoints.offers(entrypoints.RULES)))
        if len(path) == 1:
            rules.pop(Role.POA_PPS.key, None)
            missing = [role.key for role in Role.POA_PPS.excludes if rules.get(role.key) is None]
            self.replaced |= {(role,) for role in missing}
            return {**rules, **dict.fromkeys(missing, stand_in)}
        role = str(path[1])
        if role not in ROLES or (ROLES[role].many and len(path) == 2):
            return _without(rules, [role])
        if not ROLES[role].many:
            others = [other.key for other in ROLES[role].excludes]
            if isinstance(rules[role], Mapping) and "rule" not in rules[role] and rules.keys() & others:
                return _without(rules, [role])  # a parameter of a rule that is not the one chosen
            self.replaced.add((role,))
            return {**rules, role: stand_in}
        number = path[2]
        self.replaced.add((role, number))
        return {**rules, role: [stand_in if i == number else one for i, one in enumerate(rules[role])]}

    def rules(self, scenario: Scenario) -> dict[KeyPath, BoundRule]:
        """Return the rules that can be made, by their path below `rules`."""
        found = {}
        for path, choice in rule_choices(scenario.rules):
            if path not in self.replaced and (bound := self._rule(scenario.folder, path, choice)) is not None:
                found[path] = bound
        return found

    def _rule(self, folder: str, path: KeyPath, choice: RuleChoice) -> BoundRule | None:
        roles = (ROLES[str(path[0])],)
        if is_inline(choice.rule) and self.allow_inline:
            file = str(Path(folder) / choice.rule.rpartition(":")[0])
            self.found.inline_files += [file] if file not in self.found.inline_files else []
        named = choice.parameters
        while True:
            place = dotted(("rules", *path))
            try:
                return load_rule(choice, roles, folder=folder, allow_inline=self.allow_inline, place=place)
            except InputError as error:
                name = undotted(error.place)[-1]
                if error.place != place and name in named and name not in choice.parameters:
                    return None  # it cannot do without what was refused
                self.note(error.place, error.problem)
                if error.place == place or name not in choice.parameters:
                    return None
                rest = {key: value for key, value in choice.parameters.items() if key != name}
                choice = evolve(choice, parameters=rest)

    def instance(self, scenario: Scenario) -> Instance | None:
        """Return the instance, if it can be made."""
        if ("instance",) in self.doubtful:
            return None
        mistakes: list[InputError] = []
        try:
            instance = unchecked_instance(scenario, mistakes.append)
        except InputError as error:
            mistakes = [error]
        alike: dict[tuple[str, str], list[InputError]] = {}
        for mistake in mistakes:
            alike.setdefault((re.sub(r", line \d+", "", mistake.place), mistake.problem), []).append(mistake)
        for (_, what), (first, *others) in [*alike.items()][:MOST_IN_FILES]:
            self.note(first.place, what + (f"; so in {counted(len(others), 'more line')}" if others else ""))
        if left := [one for several in [*alike.values()][MOST_IN_FILES:] for one in several]:
            self.note("instance", f"and {len(left):,} more mistakes in its files")
        if mistakes:
            return None
        for problem in instance_problems(instance, scenario):
            self.note(problem.place, problem.problem)
        return instance

    def layout(self, scenario: Scenario) -> Layout | None:
        """Return the layout, if it can be made."""
        if ("layout",) in self.doubtful:
            return None
        try:
            return make_layout(scenario)
        except InputError as error:
            self.note(error.place, error.problem)
            return None

    def needs(self, scenario: Scenario, instance: Instance, bound: Mapping[KeyPath, BoundRule]) -> None:
        """Look for what rules need and the scenario does not have."""
        for path, rule in bound.items():
            for problem in unmet_needs(rule, dotted(("rules", *path)), scenario, instance):
                self.note(problem.place, problem.problem)

    def opening(self, scenario: Scenario, instance: Instance, layout: Layout) -> None:
        """Hold pods, robots and stations against the layout."""
        pods = {pod.name for pod in instance.pods}
        there = {
            station: names
            for station, names in scenario.instance.pods_at_stations.items()
            if pods.issuperset(names)  # the others are reported already
        }
        scenario = evolve(scenario, instance=evolve(scenario.instance, pods_at_stations=there))
        while True:
            try:
                open_warehouse(scenario, instance, layout)
            except InputError as error:
                if not self.note(error.place, error.problem):
                    return
                if error.place == "instance.pods":
                    instance = evolve(instance, pods=instance.pods[: len(layout.storage_locations)])
                    scenario = _mended_opening(scenario, ("instance", "pods_at_stations"), layout)
                else:
                    scenario = _mended_opening(scenario, undotted(error.place), layout)
            else:
                return

    def whole(self, scenario: Scenario, instance: Instance, layout: Layout) -> None:
        """Make all that a run makes: nothing may be left that only this would find."""
        try:
            rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=self.allow_inline)
            begun = begin(scenario, instance, layout)
            of, own = (scenario, instance) if begun is None else (begun.scenario, begun.instance)
            Simulation(of, own, layout, rules, begun=begun)
        except InputError as error:
            self.note(error.place, error.problem)
            return
        self.found.sizes = {
            "orders": len(instance.orders),
            "items": sum(order.items for order in instance.orders),
            "SKUs": len(instance.skus),
            "pods": len(instance.pods),
            "stations": len(layout.stations) - layout.replenishing,
            "robots": scenario.robots.count,
        }
        if not instance.orders:
            self.found.notes.append("Note: there are no orders.")
        until, warmup = scenario.run.until_s, scenario.run.warmup_s
        if until is not None and warmup is not None and warmup >= until:
            ends = f"the run ends (`run.until_s` = {until:g}) no later than its warm-up (`run.warmup_s` = {warmup:g})"
            self.found.notes.append(f"Note: {ends}: nothing that is measured counts.")
        if scenario.stations.oversize == "alone":
            refusing = evolve(scenario, stations=evolve(scenario.stations, oversize="refuse"))
            for problem in oversize_orders(instance, refusing):
                self.found.notes.append(
                    f"Note: {problem.problem.partition(';')[0]}; rules that do not split them give each an empty one."
                )
        self.found.notes += [*_starving(scenario, instance, rules), *_misspelt(scenario, instance)]
        self.found.notes += [*_levels(scenario, instance), *idle_notes(scenario, layout)]
        self.found.notes += _while_closed(scenario, instance, layout)
        self.found.notes += [*_next_day(scenario, instance), *_paid_for_nothing(scenario, instance, layout)]
        self.found.loads = loads(scenario, instance, layout)


def _starving(scenario: Scenario, instance: Instance, rules: RuleSet) -> list[str]:
    """Say that item capacity goes to small orders, where a parameter of the rule for orders could prevent it."""
    poa, sizes = rules.poa, {order.items for order in instance.orders}
    if poa is None or scenario.stations.order_capacity is not None or len(sizes) < 2:
        return []
    if getattr(poa.instance, "max_wait_s", 0) is not None:
        return []
    return [
        "Note: stations count items, so capacity becomes free in small amounts that fit only small orders; "
        f"large ones wait; parameter `max_wait_s` of {poa.name} limits how long, and `stations.order_capacity` counts "
        "orders instead."
    ]


def _while_closed(scenario: Scenario, instance: Instance, layout: Layout) -> Iterator[str]:
    """Say how many orders arrive while no station is open, where it is most, and how many trucks leave before one is.

    Orders that all arrive at once are a backlog, which waits for stations to open as a matter of course.
    """
    picking = len(layout.stations) - layout.replenishing
    stations = {*shifts_of(hours_of(scenario, picking), picking)[0]}
    opens = {}
    for tick in {order.arrival_tick for order in instance.orders}:
        times = (tick if one.at(tick) else one.next_change(tick) for one in stations)
        opens[tick] = min((time for time in times if time is not None), default=tick)
    number = len(instance.orders)
    closed = sum(opens[order.arrival_tick] > order.arrival_tick for order in instance.orders)
    if 2 * closed > number and len(opens) > 1:
        which = "all" if closed == number else f"{closed:,} of"
        yield f"Note: {which} {counted(number, 'order')} arrive while no station is open (`stations.open`)."
    if scenario.instance.departures is not None:
        gone = sum(
            order.due_tick is not None and order.due_tick <= opens[order.arrival_tick] for order in instance.orders
        )
        if gone:
            yield f"Note: the trucks of {counted(gone, 'order')} leave before a station opens (`stations.open`)."


def _next_day(scenario: Scenario, instance: Instance) -> Iterator[str]:
    """Say how many orders arrive after the last truck of their day."""
    if scenario.instance.departures is not None:
        zero = Calendar(scenario.instance.start).time_of_day()
        spans = [(order.arrival_tick + zero, order.due_tick) for order in instance.orders]
        late = sum(due is not None and (due + zero) // DAY > arrival // DAY for arrival, due in spans)
        if late:
            goes = "order goes with a truck of a later day than it arrives on"
            go = "orders go with a truck of a later day than they arrive on"
            yield f"Note: {late:,} {goes if late == 1 else go}."


def _paid_for_nothing(scenario: Scenario, instance: Instance, layout: Layout) -> Iterator[str]:
    """Say which costs are those of nobody, and that people are paid long before the first order."""
    costs = scenario.costs
    if costs is None:
        return
    if costs.packer_per_h and scenario.packing is None:
        yield "Note: `costs.packer_per_h` is paid to nobody: there are no packing stations."
    if costs.replenisher_per_h and not layout.replenishing:
        yield "Note: `costs.replenisher_per_h` is paid to nobody: there are no replenishment stations."
    if (costs.late_order or costs.late_h) and all(order.due_tick is None for order in instance.orders):
        yield "Note: `costs.late_order` and `costs.late_h` count nothing: no order has a due time."
    first = min((order.arrival_tick for order in instance.orders), default=0)
    hours = first / (DAY / 24) - (scenario.run.warmup_s or 0) / 3600
    if costs.picker_per_h and scenario.stations.open is None and hours > 1:
        yield (
            f"Note: pickers are paid for {hours:.1f} h before the first order arrives; `stations.open` says when "
            "stations open, or `instance.start` where time 0 is."
        )


def _levels(scenario: Scenario, instance: Instance) -> Iterator[str]:
    """Say which reorder levels in items are raised for an order line, and which are more than all pods can hold."""
    given, file, room = scenario.instance.replenishment, scenario.instance.skus_file, scenario.instance.pod_capacity
    if given is None or not instance.levels:
        return
    told = {} if file is None else read_skus(Path(scenario.folder) / file)
    raised, beyond, needed = [], [], 0
    for i, (name, (low, full)) in enumerate(zip(instance.skus, instance.levels, strict=True)):
        asked = told.get(name, {}).get("reorder_point", given.reorder_point)
        if given.unit == "items" and asked is not None and asked < low:
            raised.append(f"SKU {name} from {asked:g} to {low}, as an order line wants {low + 1} items of it")
        size = instance.sizes[i] if instance.sizes else 1
        needed += full * size
        if room is not None and full > (most := len(instance.pods) * (room // size)):
            beyond.append(f"SKU {name} ({full:,}, and space for {most:,})")
    if raised:
        more = f"; {len(raised) - 1:,} more SKUs likewise" if len(raised) > 1 else ""
        yield f"Note: the reorder point is raised of {raised[0]}{more}."
    if beyond:
        yield f"Note: `order_up_to` is more than all pods together have space for: {first_few(beyond)}."
    elif room is not None and needed > (space := len(instance.pods) * room):
        yield (
            f"Note: stock up to `order_up_to` of all SKUs needs space for {needed:,}, and all pods together have "
            f"{space:,}; bundles may wait for space."
        )


def _misspelt(scenario: Scenario, instance: Instance) -> list[str]:
    """Say which SKUs files name and nothing else does: they may be slips of the pen."""
    notes, file = [], scenario.instance.skus_file
    if file is not None:
        unknown = [sku for sku in read_skus(Path(scenario.folder) / file) if sku not in {*instance.skus}]
        if unknown:
            notes.append(f"Note: {file} has SKUs that no pod, order or bundle has: {first_few(unknown)}.")
    known = {sku for order in instance.orders for sku, _ in order.lines}
    known |= {sku for pod in instance.pods for sku, _ in pod.contents}
    unwanted = [instance.skus[sku] for sku in sorted({bundle.sku for bundle in instance.bundles} - known)]
    if unwanted:
        notes.append(f"Note: bundles bring SKUs that no pod has and no order wants: {first_few(unwanted)}.")
    return notes


def idle_notes(scenario: Scenario, layout: Layout) -> list[str]:
    """Say that no robot ever works, or none while a station is open, where that is so."""
    picking = len(layout.stations) - layout.replenishing
    stations, robots = shifts_of(hours_of(scenario, picking), picking)
    if first_common(robots) is None:
        return ["Note: `robots.available` has no robot on duty at any time."]
    if first_common(stations, robots) is None:
        return [
            "Note: no robot is on duty while a station is open (`robots.available`, `stations.open`), so robots work "
            "off only what stations took before they closed."
        ]
    return []


def _mended_opening(scenario: Scenario, path: KeyPath, layout: Layout) -> Scenario:
    """Return the scenario with values that fit the layout instead of those that do not."""
    if path[0] == "robots":
        return evolve(scenario, robots=evolve(scenario.robots, count=len(layout.storage_locations), file=None))
    if path[0] == "stations":
        return evolve(scenario, stations=evolve(scenario.stations, item_capacity=1, order_capacity=None))
    left = {station: names for station, names in scenario.instance.pods_at_stations.items() if station not in path[2:3]}
    return evolve(scenario, instance=evolve(scenario.instance, pods_at_stations=left if len(path) > 2 else {}))


def _without(table: Mapping[str, Any], path: Sequence[str]) -> dict[str, Any]:
    """Return nested tables without the key at a path."""
    key, *rest = path
    inner = table.get(key)
    if rest and isinstance(inner, Mapping):
        return {**table, key: _without(inner, rest)}
    return {name: value for name, value in table.items() if name != key}
