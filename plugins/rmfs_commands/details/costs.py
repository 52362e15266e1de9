"""The cost of a run by the section ``costs`` of its scenario: in all, and by its parts for each order.

With T the hours of the run after its warm-up, the parts are

    pickers        picker_per_h * hours in which picking stations are open, finish what they have or store a bundle
    packers        packer_per_h * hours in which packers are there, or finish a task, and sorters are
    replenishers   replenisher_per_h * T * replenishment stations
    robots         (robot_per_h + robot_per_year / hours_per_year) * T * robots
    energy         kwh * energy
    lateness       late_order * late orders + late_h * hours by which they are late

A picker is also paid through an outage of the station that begins in these hours. Energy is what the batteries gave, by
the draws of ``robots.battery``; without batteries it is the metric ``energy_wh``. Orders are done when they are packed,
where packing is simulated, or else picked. One that is due and not done is late up to the end of the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rmfs_commands.details.spans import Number, ratio
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.scenario.model import Costs

HOUR = 3600 * TICKS_PER_S
PARTS = ("pickers", "packers", "replenishers", "robots", "energy", "lateness")


def lateness(orders: Iterable[tuple[object, int, int | None]], end: int) -> tuple[int, int]:
    """Return how many orders are late, and by how many ticks in all; each is given with its due tick and when done."""
    late = [(end if done is None else done) - due for _, due, done in orders]
    late = [ticks for ticks in late if ticks > 0]
    return len(late), sum(late)


def values(
    costs: Costs, paid: Mapping[str, int], wh: float, late: tuple[int, int] | None, done: int
) -> dict[str, Number]:
    """Return the metrics by name.

    Parameters
    ----------
    costs
        Costs of the scenario.
    paid
        Ticks that are paid of each kind, by the names of the parts.
    wh
        Energy.
    late
        As `lateness` returns it; None where no order has a due time.
    done
        Orders that are done.
    """
    robot_per_h = costs.robot_per_h + costs.robot_per_year / costs.hours_per_year
    rates = dict(
        zip(PARTS, (costs.picker_per_h, costs.packer_per_h, costs.replenisher_per_h, robot_per_h), strict=False)
    )
    parts = {part: rates[part] * ticks / HOUR for part, ticks in paid.items()}
    parts["energy"] = costs.kwh * wh / 1000
    if late is not None:
        parts["lateness"] = costs.late_order * late[0] + costs.late_h * late[1] / HOUR
    total = sum(parts.values())
    of_orders = {f"cost_{part}_per_order": ratio(cost, done) for part, cost in parts.items()}
    return {"cost_total": total, "cost_per_order": ratio(total, done), **of_orders}
