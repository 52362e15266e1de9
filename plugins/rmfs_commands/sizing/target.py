"""Targets that a warehouse shall keep."""

from __future__ import annotations

from collections.abc import Collection
from typing import NoReturn

from attrs import evolve, frozen

from rmfs_commands.details.catalogue import DEPARTURES, FROM_ORDERS, LATENESS, MEASURES, METRICS, MORE_IS_BETTER
from rmfs_commands.results.figures import show
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric
from rmfs_core.world import Instance

KNOWN = {metric.name: metric for group in METRICS.values() for metric in group} | {one.name: one for one in MEASURES}
"""Metrics of every run, by name."""

ON_TIME = "on_time_percent_priority_"
"""Before a priority: it may be any."""

_COSTS = {"stations": "cost_pickers_per_order", "robots": "cost_robots_per_order", "packers": "cost_packers_per_order"}
"""Cost of more of a thing, which raises `cost_total` and `cost_per_order`, too. The search tries the most first, and
would miss sizes that keep a limit of these."""

EXPECTED = "expected one of which less is better, such as turnover_p95_s"


@frozen
class Target:
    """A metric, whose mean over seeds shall be at most ``most``.

    Parameters
    ----------
    metric
        A figure of result.json, the less the better.
    most
        The limit.
    confidence
        With which a size is found to keep it, or not to.
    seeds
        The most seeds, in the order in which they are taken.
    """

    metric: str
    most: float
    confidence: float = 0.95
    seeds: tuple[int, ...] = tuple(range(1, 17))

    @property
    def option(self) -> str:
        """Its name in messages."""
        return f"--most {self.metric}={self.most:g}"

    def check(self, instances: Collection[Instance], sought: Collection[str] = ()) -> None:
        """Raise `InputError` for a metric of which "at most" says nothing, whatever is run, with these orders.

        ``sought`` names the things of which several numbers are tried.
        """
        if self.metric in MORE_IS_BETTER or self.metric.startswith(ON_TIME):
            raise InputError(self.option, f"more of `{self.metric}` is better; {EXPECTED}")
        if self.metric in FROM_ORDERS:
            raise InputError(self.option, f"`{self.metric}` is the same for every number of robots; {EXPECTED}")
        costs = {thing: ("cost_total", "cost_per_order", own) for thing, own in _COSTS.items() if thing in sought}
        if raising := [thing for thing, raised in costs.items() if self.metric in raised]:
            more = f"more {' or '.join(raising)} raise `{self.metric}`"
            problem = f"{more}; expected a metric that they lower, such as turnover_p95_s"
            cheapest = "of the sizes that keep it the answer names the one in which an order costs least"
            raise InputError(self.option, f"{problem}: {cheapest}")
        if self.most < 0 and self.metric in KNOWN:
            raise InputError(self.option, f"`{self.metric}` is never below 0; expected a number >= 0")
        due = any(order.due_tick is not None for instance in instances for order in instance.orders)
        if not due and self.metric in {metric.name for metric in (*LATENESS, *DEPARTURES)}:
            self.refuse("no order has a due time")

    def refuse(self, why: str) -> NoReturn:
        """Raise `InputError` since no run has the metric."""
        raise InputError(self.option, f"these runs have no `{self.metric}`: {why}; expected one that they have")

    @property
    def described(self) -> Metric:
        """The metric for people; of what somebody's observer measures only the name is known."""
        return KNOWN.get(self.metric) or Metric(self.metric, self.metric, "", 3, "")

    @property
    def label(self) -> str:
        """Its name in titles and sentences: an indented label follows that of the metric above it."""
        label = self.described.label
        if not label.startswith(" "):
            return label
        names = list(KNOWN)
        above = (KNOWN[name].label for name in reversed(names[: names.index(self.metric)]))
        parent = next(found for found in above if not found.startswith(" "))
        return f"{parent.partition(',')[0]}, {label.strip()}"

    def shown(self, value: float) -> str:
        """Return one of its values without the unit; those of numbers are means, with the digits of the limit."""
        digits = self.described.digits or max(1, len(f"{self.most:g}".partition(".")[2]))
        return show(evolve(self.described, digits=digits), float(value))

    def with_unit(self, value: float) -> str:
        """Return one of its values."""
        return f"{self.shown(value)} {self.described.unit}".rstrip()
