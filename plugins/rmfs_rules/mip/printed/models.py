"""The three models exactly as the paper prints them: one variable and one row for each of its own.

For study, and as the oracle of `rmfs_rules.mip.proof`. A line for q items takes q slots in (4); the paper has q = 1.
Packing capacity (3.2), (16) to (20): (18) is summed over the orders, an order that is split already does not count
again, and in the split-over-time model an order with a line left in the backlog is split too. Where pods may run out,
q_ips says how many items of SKU i station s takes from pod p, and f_ip how many are free there. A station with order
capacity counts parts of orders in (4): the sum of y_os, without orders that have a slot there already.
"""

from __future__ import annotations

import mip
from attrs import define

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Model, Solution, is_useful, is_whole, objective_of, parts_from, unused
from rmfs_rules.mip.printed.solver import Limits, new_model, optimise


@define
class _Printed:
    """A model under construction and the variables of the paper."""

    period: Period
    kind: Model
    weight: float
    model: mip.Model
    x: dict[tuple[int, int], mip.Var]  # (pod, station)
    y_os: dict[tuple[int, int], mip.Var]  # (order, station)
    y_ios: dict[tuple[int, int, int], mip.Var]  # (SKU, order, station)
    u: list[mip.Var]


def solve_printed(
    period: Period, kind: Model, weight: float, limits: Limits, packing_capacity: int | None = None
) -> Solution:
    """Build a model as printed and solve it. Where a limit comes before any solution, nothing is assigned.

    Parameters
    ----------
    period
        The period.
    kind
        Which of the three models.
    weight
        W_u.
    limits
        Solver and limits.
    packing_capacity
        C of (18); None for no limit on split orders.
    """
    printed = _build(period, kind, weight, limits, packing_capacity)
    whole = is_whole(weight)
    outcome = optimise(printed.model, limits, absolute_gap=0.999 if whole else 1e-6, seconds=limits.max_seconds)
    if outcome.values is None:
        there = tuple((pod, station) for station, pods in enumerate(period.inbound) for pod in pods)
        value = len(there) + weight * unused(period, ())
        return Solution((), there, value, min(outcome.bound, value), "stopped")
    y_ios = sorted(printed.y_ios.items(), key=lambda one: one[0][1:])
    parts = parts_from((order, station, sku) for (sku, order, station), y in y_ios if y.x > 0.5)
    visits = tuple(key for key, variable in printed.x.items() if variable.x > 0.5)
    if outcome.optimal and limits.gap == 0:
        value = round(outcome.objective) if whole else outcome.objective
        return Solution(parts, visits, value, value, "solver")
    visits = tuple((p, s) for p, s in visits if p in period.inbound[s] or is_useful(period, p, s, parts))
    value = objective_of(period, parts, len(visits), weight)
    return Solution(parts, visits, value, min(outcome.bound, value), "stopped")


def _build(period: Period, kind: Model, weight: float, limits: Limits, packing_capacity: int | None = None) -> _Printed:
    """Build a model as printed."""
    model = new_model(limits)
    stations, orders, pods = range(len(period.stations)), range(len(period.orders)), range(len(period.stock.pods))
    binary = {"var_type": mip.BINARY}
    printed = _Printed(
        period,
        kind,
        weight,
        model,
        x={(p, s): model.add_var(**binary) for p in pods for s in stations},
        y_os={(o, s): model.add_var(**binary) for o in orders for s in stations},
        y_ios={(i, o, s): model.add_var(**binary) for o in orders for i, _ in period.lines[o] for s in stations},
        u=[model.add_var(var_type=mip.INTEGER) for _ in stations],
    )
    _add_common(printed)
    _add_stock(printed)
    if kind is Model.INTEGRATED:
        _add_whole_orders(printed)
    else:
        _add_split_orders(printed, packing_capacity)
    return printed


def _add_common(p: _Printed) -> None:
    period, m, stations = p.period, p.model, range(len(p.period.stations))
    # (1)
    m.objective = mip.xsum(p.x.values()) + mip.xsum(p.weight * f * u for f, u in zip(period.factors, p.u, strict=True))
    for s in stations:
        if s in period.counting_orders:
            taken = mip.xsum(period.slots(o, s, 0) * p.y_os[o, s] for o in range(len(period.orders)))
        else:
            taken = mip.xsum(q * p.y_ios[i, o, s] for o, lines in enumerate(period.lines) for i, q in lines)
        m += taken + p.u[s] == period.capacities[s]  # (4)
    pods_with: dict[int, list[int]] = {}
    for pod, i in zip(period.stock.pod.tolist(), period.stock.sku.tolist(), strict=True):
        pods_with.setdefault(i, []).append(pod)
    for (i, _, s), y in p.y_ios.items():
        m += mip.xsum(p.x[pod, s] for pod in pods_with.get(i, ())) - y >= 0  # (5)
    for s in stations:
        for pod in period.inbound[s]:
            m += p.x[pod, s] == 1  # (6)


def _add_stock(p: _Printed) -> None:
    """The rows of finite stock. No pod gives more than the stations take: f_ip is cut off there."""
    period, m, stock = p.period, p.model, p.period.stock
    if stock.number is None:
        return
    stations, room = range(len(period.stations)), sum(period.rooms)
    wanted: dict[int, list[tuple[int, int]]] = {}
    for o, lines in enumerate(period.lines):
        for i, d in lines:
            wanted.setdefault(i, []).append((o, d))
    taken: dict[tuple[int, int], list[mip.Var]] = {(i, s): [] for i in wanted for s in stations}
    for pod, i, free in zip(stock.pod.tolist(), stock.sku.tolist(), stock.number.tolist(), strict=True):
        if i in wanted:
            q = [m.add_var(var_type=mip.INTEGER) for _ in stations]
            for s in stations:
                m += q[s] <= min(free, room) * p.x[pod, s]  # q_ips <= f_ip x_ps
                taken[i, s].append(q[s])
            m += mip.xsum(q) <= min(free, room)  # sum over s of q_ips <= f_ip
    for (i, s), variables in taken.items():
        m += mip.xsum(variables) == mip.xsum(d * p.y_ios[i, o, s] for o, d in wanted[i])  # sum over p of q_ips


def _add_whole_orders(p: _Printed) -> None:
    for (_, o, s), y in p.y_ios.items():
        p.model += p.y_os[o, s] == y  # (2)
    for o in range(len(p.period.orders)):
        p.model += mip.xsum(p.y_os[o, s] for s in range(len(p.period.stations))) <= 1  # (3)


def _add_split_orders(p: _Printed, packing_capacity: int | None) -> None:
    m, stations = p.model, range(len(p.period.stations))
    y_o = [m.add_var(var_type=mip.BINARY) for _ in p.period.orders]
    y_b = {}
    for o, lines in enumerate(p.period.lines):
        at = mip.xsum(p.y_os[o, s] for s in stations)
        m += at >= y_o[o]  # (3.1)
        for i, _ in lines:
            there = mip.xsum(p.y_ios[i, o, s] for s in stations)
            if p.kind is Model.SPLIT_AMONG_STATIONS:
                m += there == y_o[o]  # (11)
            else:
                y_b[i, o] = m.add_var(var_type=mip.BINARY)
                m += there + y_b[i, o] == y_o[o]  # (11.1)
        for s in stations:
            m += y_o[o] >= p.y_os[o, s]  # (12)
            m += mip.xsum(p.y_ios[i, o, s] for i, _ in lines) >= p.y_os[o, s]  # (13)
            for i, _ in lines:
                m += p.y_os[o, s] >= p.y_ios[i, o, s]  # (2.1)
    if packing_capacity is not None:
        _add_packing(p, packing_capacity, y_o, y_b)


def _add_packing(p: _Printed, packing_capacity: int, y_o: list[mip.Var], y_b: dict[tuple[int, int], mip.Var]) -> None:
    m, stations = p.model, range(len(p.period.stations))
    split = []
    for o, lines in enumerate(p.period.lines):
        e = m.add_var(var_type=mip.INTEGER)
        y_l = m.add_var(var_type=mip.BINARY)
        m += mip.xsum(p.y_os[o, s] for s in stations) - e == y_o[o]  # (3.2)
        m += y_l >= e / len(stations)  # (16)
        left = mip.xsum(y_b[i, o] for i, _ in lines if (i, o) in y_b)
        m += y_l <= e + left  # (17)
        for i, _ in lines:
            if (i, o) in y_b:
                m += y_l >= y_b[i, o]
        if not p.period.begun_before(o):
            split.append(y_l)
    room = max(packing_capacity - p.period.split_open, 0)
    m += mip.xsum(split) <= room  # (18)
