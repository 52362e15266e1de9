"""Energy of robots, and their moves without a task: metrics of `rmfs_commands.details`, computed again."""

from __future__ import annotations

import math
from collections import defaultdict

from rmfs_commands.processes.events import ChargerDown, ChargerUp
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.tables import are_sent, has_batteries, robots_of
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import PodLifted, PodMoveDecided, PodStored, RobotMoved, RobotRested, RobotSent, TaskAssigned

WH = 3600
ROBOT_KG, POD_KG, RESISTANCE, EFFICIENCY, SIDE_M, HALF_TRACK_M, LIFT_M, G = 150, 450, 0.015, 0.8, 0.9, 0.3, 0.05, 9.81


def recompute_robots(trace: Trace, begin: int, completed: int) -> dict[str, float | None]:
    """Return the metrics by name, except for the lowest charge, which the trace does not tell."""
    joules = _energy(trace, begin)
    hours = {f"energy_{part}_wh": amount / WH / EFFICIENCY for part, amount in joules.items()}
    total = sum(hours.values())
    found: dict[str, float | None] = {"energy_wh": total, **hours}
    found["energy_per_order_wh"] = total / completed if completed else None
    doing: dict[int, str] = {}
    metres: dict[str, int] = defaultdict(int)
    moved, charges, broken = 0, 0, set[int]()
    for event in trace.events:
        counts = event.tick >= begin
        match event:
            case RobotSent():
                doing[event.robot] = "resting"
            case ChargerDown():
                broken.add(event.cell)
            case ChargerUp():
                broken.discard(event.cell)
            case PodMoveDecided():
                doing[event.robot] = "moving"
            case TaskAssigned():  # on a floor that took back what it was sent for before
                doing.pop(event.robot, None)
            case RobotRested():
                charges += counts and event.cell in trace.layout.chargers and event.cell not in broken
                doing.pop(event.robot, None)
            case PodStored():
                moved += counts and event.robot in doing
                doing.pop(event.robot, None)
            case RobotMoved() if counts:
                metres[doing.get(event.robot, "")] += trace.layout.distance(event.origin, event.to)
    found["picking_distance_per_order_m"] = metres[""] / completed if completed else None
    rules = trace.scenario.get("rules", {})
    if are_sent(trace):
        found["resting_distance_m"] = metres["resting"]
    if "move" in rules:
        found |= {"pods_moved": moved, "moving_distance_m": metres["moving"]}
    if has_batteries(trace):
        at_chargers = [float(row["charging_s"] or 0) for row in robots_of(trace)]
        span = len(at_chargers) * (max(trace.tick, begin) - begin) / TICKS_PER_S
        found |= {"charges": charges, "charging_percent": 100 * sum(at_chargers) / span if span else None}
    return found


def _energy(trace: Trace, begin: int) -> dict[str, float]:
    """Return what the drives bring to the wheels and lifts, in joules."""
    a, v, turn_s = (
        trace.motion.acceleration_m_per_s2,
        trace.motion.top_speed_m_per_s,
        trace.motion.full_turn_s,
    )
    joules = dict.fromkeys(("acceleration", "rolling", "turns", "lifts"), 0.0)
    for event in trace.events:
        if event.tick < begin:
            continue
        if isinstance(event, PodLifted):
            joules["lifts"] += POD_KG * G * LIFT_M
        elif isinstance(event, RobotMoved):
            mass = ROBOT_KG + (0 if event.pod is None else POD_KG)
            metres = trace.layout.distance(event.origin, event.to)
            fastest = min(v, math.sqrt(a * metres))
            ramp = fastest**2 / 2 / a
            joules["acceleration"] += mass * fastest**2 / 2
            joules["rolling"] += mass * RESISTANCE * G * (metres - ramp) + mass * max(RESISTANCE * G - a, 0) * ramp
            if quarters := round(4 * event.turn_ticks / TICKS_PER_S / turn_s):
                spin = mass * SIDE_M**2 / 6 * (2 * math.pi / turn_s) ** 2 / 2
                joules["turns"] += spin + mass * RESISTANCE * G * HALF_TRACK_M * quarters * math.pi / 2
    return joules
