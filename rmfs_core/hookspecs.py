"""The hooks: everything a rule or an observer can implement, top to bottom.

A rule is an attrs class: its fields are its parameters, its `@hookimpl` methods decide. A method may leave out
arguments that it does not need. The classes named here are documented in `rmfs_core.warehouse` (what a rule sees) and
`rmfs_core.decisions` (what it returns). A rule's class declares its other traits as attributes, such as its ``needs``
and how it ``reserves``: `rmfs_core.rules.traits.RuleTraits` has them all.

Rules only look at the warehouse and return values; the kernel checks each decision and applies it. A decision that is
impossible ends the run with an error that names the rule. Ids are whole numbers; numpy integers are accepted. A
rule that remembers anything forgets it in `run_started`: then an instance can be used for any number of runs.

Two arguments are the same wherever a decision is made: ``warehouse`` is the warehouse now, with what the prefilters
left of the backlog; ``rng`` is the rule's own stream of random numbers, spawned from the scenario's seed, and the only
one to draw from.

Each hook has an example, a whole rule or observer, in the reference of the documentation (docs/reference/hooks.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pluggy

if TYPE_CHECKING:
    from rmfs_core.decisions import (
        BundleAssignment,
        BundleDecision,
        JointDecision,
        OrderAssignment,
        Path,
        PodMove,
        PodTrip,
        RobotMove,
        StoreBundle,
        TaskAssignment,
    )
    from rmfs_core.events import Event
    from rmfs_core.info import Question, RunInfo
    from rmfs_core.warehouse import Order, PackingStation, PackingTask, Pod, Robot, WarehouseView

hookspec = pluggy.HookspecMarker("rmfs")
hookimpl = pluggy.HookimplMarker("rmfs")


class DecisionHooks:
    """Exactly one selected rule answers each of these.

    The hooks for bundles, active stations, resting robots, moved pods and packing are called only if the scenario names
    a rule for them, or has packing stations.
    """

    @hookspec(firstresult=True)
    def assign_orders(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[OrderAssignment]:
        """POA: assign orders of the backlog to picking stations.

        Called in a decision round while some station's free capacity fits the smallest order of the backlog.

        Returns
        -------
        Sequence[OrderAssignment]
            Assignments, applied in this order; each must fit what is then free at its station. An empty sequence
            assigns nothing until something changes.
        """

    @hookspec(firstresult=True)
    def select_pods(self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator) -> Sequence[PodTrip]:
        """PPS: choose pods to visit stations.

        Called in a decision round when stations have open requests that no inbound pod can serve
        (``station.uncovered_requests``) and a robot could start now, or a pod about to leave a station could go on.
        Candidates are ``warehouse.free_pods`` (stored and bound nowhere; each needs a robot) and
        ``warehouse.leaving_pods`` (at a station with nothing left to serve there and bound nowhere else; the robot that
        carries them goes on).

        Parameters
        ----------
        max_fetches
            How many trips of stored pods may be decided now.

        Returns
        -------
        Sequence[PodTrip]
            Trips. Each pod at most once, and only to a station where it holds a free item (``pod.free_items``) for a
            request that is uncovered now. An empty sequence sends nothing until something changes.
        """

    @hookspec(firstresult=True)
    def assign_orders_and_pods(self, warehouse: WarehouseView, rng: np.random.Generator) -> JointDecision:
        """POA and PPS together (instead of the two hooks above).

        Called when POA would be: each call is one period. The trips it decides wait in line for robots.

        Returns
        -------
        JointDecision
            Assignments and the pod trips they need. Every assigned request must be servable by a pod inbound to its
            station once the trips are counted in. A trip may name any pod that is not at or bound for that station
            already, stored or under way to others, which it visits first; it must hold a SKU of a request open there.
            More trips than robots may be named, and one pod for several stations.
        """

    @hookspec(firstresult=True)
    def choose_storage_location(self, warehouse: WarehouseView, pod: Pod, rng: np.random.Generator) -> int:
        """PR: name the storage location a pod goes back to.

        Called when a pod leaves a station and is bound for no other, or the next station's queue is full (then the pod
        is stored, and fetched again when the queue has space: no robot keeps a queue cell while it waits for another).

        Parameters
        ----------
        pod
            The pod; ``pod.cell`` is where it stands.

        Returns
        -------
        int
            One of ``warehouse.free_storage_locations``, cell indices.
        """

    @hookspec(firstresult=True)
    def assign_tasks(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[TaskAssignment]:
        """TA: give waiting pods to idle robots.

        Called in a decision round while ``warehouse.waiting_pods`` and ``warehouse.idle_robots`` both have entries.

        Returns
        -------
        Sequence[TaskAssignment]
            Assignments; each robot and each pod at most once. Pods left out wait for the next round.
        """

    @hookspec(firstresult=True)
    def plan_path(
        self, warehouse: WarehouseView, robot: Robot, goal: int, traffic: Any, rng: np.random.Generator
    ) -> Path | None:
        """PP: plan a robot's path from where it stands to a cell.

        Called when a robot has to go somewhere, and again where a path ends before the goal or, for a rule that
        reserves windows, a run is refused. ``warehouse.travel`` has the grid and exact travel times.

        Parameters
        ----------
        robot
            The robot: ``robot.cell``, ``robot.heading``, and ``robot.pod``, None when it drives empty.
        goal
            The cell index it has to reach.
        traffic
            For a rule that ``reserves``, what its way of driving hands it. With full paths and windows this is a
            `Traffic`: what the other robots have reserved, and from where and when this robot can set out; a robot
            that is on its way sets out where the leg under way ends. None for a rule that does not.

        Returns
        -------
        Path | None
            The legs to drive; no legs only for a robot that sets out from the goal itself. A rule that reserves returns
            None if there is no path. With windows the robot then stays, and the rule is asked again two seconds later,
            unless others keep all cells next to it; with full paths this happens only to two robots on the way to a
            station, which change positions in line if both have a path.
        """

    @hookspec(firstresult=True)
    def plan_paths(
        self, warehouse: WarehouseView, queries: Sequence[Any], traffic: Any, rng: np.random.Generator
    ) -> dict[int, Path]:
        """PP: plan paths for all robots that need one now, and new paths for robots that have one.

        Answered instead of `plan_path` by a rule with ``reserves = "fleet"``; called when robots are given goals.
        All paths of the answer replace the reservations of these robots at once. They are checked against each other
        and against all other reservations.

        Parameters
        ----------
        queries
            A `Query` each. First robots that need a path, in the order in which they were given their goals: if they
            are planned one after another in this order, while the others keep their paths, each has a path. Then robots
            on their way, which are in ``traffic.arrives`` and may keep their paths. A robot that was delayed as often
            as there are robots, since it was given its goal, is not among them.
        traffic
            Reservations, and which of them can be given up: a `FleetTraffic`.

        Returns
        -------
        dict[int, Path]
            Legs to the robots' goals by robot id, as in `plan_path`; robots on their way may be left out.
        """

    @hookspec(firstresult=True)
    def assign_bundles(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[BundleAssignment]:
        """ROA: assign bundles to replenishment stations.

        Called in a decision round while ``warehouse.bundles`` wait and some station of
        ``warehouse.replenishment_stations`` has capacity for one (``station.free_bundle_capacity``).

        Returns
        -------
        Sequence[BundleAssignment]
            Assignments, each bundle at most once. Bundles left out wait for the next round.
        """

    @hookspec(firstresult=True)
    def select_replenishment_pods(
        self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator
    ) -> Sequence[StoreBundle]:
        """RPS: choose the pods that bundles are stored on; the kernel sends each to its bundle's station.

        Called in a decision round while stations have bundles without a pod (``bundle.pod`` is None). Candidates have
        space (``pod.free_space >= bundle.size``) and are ``warehouse.free_pods`` (each needs a robot),
        ``warehouse.leaving_pods``, or bound for a station already: these are picked from and replenished on one trip.

        Parameters
        ----------
        max_fetches
            How many stored pods that are bound nowhere may be chosen now.

        Returns
        -------
        Sequence[StoreBundle]
            Each bundle at most once; a pod may take several, as long as all of them fit it.
        """

    @hookspec(firstresult=True)
    def assign_bundles_and_pods(
        self, warehouse: WarehouseView, max_fetches: int, rng: np.random.Generator
    ) -> BundleDecision:
        """ROA and RPS together (instead of the two hooks above); called when either of them would be.

        Parameters
        ----------
        max_fetches
            As for RPS.

        Returns
        -------
        BundleDecision
            Both answers: its bundles may be put on pods as soon as they are assigned.
        """

    @hookspec(firstresult=True)
    def activate_stations(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[int]:
        """Activation: choose the stations that take orders, by load rather than by the clock.

        Called first in each decision round, if the scenario has such a rule (``rules.activate``).

        Returns
        -------
        Sequence[int]
            Ids of the stations that are active until the rule is asked again. The others take no new orders, and finish
            those that they have. An active station takes orders while its timetable has it open (``station.staffed``).
        """

    @hookspec(firstresult=True)
    def idle_robots(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[RobotMove]:
        """Send robots without a task to cells where they rest or charge.

        Called at the end of a decision round while ``warehouse.resting_robots`` has entries.

        Returns
        -------
        Sequence[RobotMove]
            Each robot and each cell at most once; cells of ``warehouse.free_rest_cells``. A robot whose charge is too
            ``low`` for a task goes to a charger only. A robot takes no task until it has arrived.
        """

    @hookspec(firstresult=True)
    def move_pods(self, warehouse: WarehouseView, max_moves: int, rng: np.random.Generator) -> Sequence[PodMove]:
        """Carry stored pods to other storage locations while there are idle robots: active repositioning.

        Called in a decision round after TA while a pod may be moved. For each pod, first to last, the kernel takes the
        idle robot that can be there first.

        Parameters
        ----------
        max_moves
            How many pods may be moved now: as many as robots can start, and as there are free storage locations beyond
            one for each pod that is being carried.

        Returns
        -------
        Sequence[PodMove]
            Pods of ``warehouse.free_pods`` that have no robot, each once, to ``warehouse.free_storage_locations``.
        """

    @hookspec(firstresult=True)
    def assign_packing(
        self, warehouse: WarehouseView, orders: Sequence[Order], rng: np.random.Generator
    ) -> Sequence[int]:
        """Choose the packing station of each order, for all its parts.

        Called once per order, after the decision that assigns its first part.

        Parameters
        ----------
        orders
            The orders. ``split`` ones need a box each: all stations together have as many free ones.

        Returns
        -------
        Sequence[int]
            Ids of ``warehouse.packing_stations``, one for each order; for a split one a station with a free box.
        """

    @hookspec(firstresult=True)
    def choose_packing_task(
        self, warehouse: WarehouseView, station: PackingStation, tasks: Sequence[PackingTask], rng: np.random.Generator
    ) -> int:
        """Choose the next task of a free packer: put a part into a box, or pack an order.

        Called when a packer, or a sorter, is free at an open packing station and has two tasks or more to choose from.

        Parameters
        ----------
        station
            The packing station.
        tasks
            Tasks that can begin now, longest waiting first.

        Returns
        -------
        int
            Position in ``tasks``, from 0.
        """


class FilterHooks:
    """Prefilters form a chain in the order in which the scenario lists them; each is asked on its own."""

    @hookspec(firstresult=True)
    def filter_backlog(
        self, warehouse: WarehouseView, orders: Sequence[Order], rng: np.random.Generator
    ) -> Sequence[Order]:
        """Choose the orders of the backlog that the assigning rule sees.

        Called before each POA or joint decision; ``warehouse`` has the whole backlog.

        Parameters
        ----------
        orders
            Orders that the filters before this one left, oldest first.

        Returns
        -------
        Sequence[Order]
            Some of ``orders``. Neither order nor repetition matters; the assigning rule sees them oldest first.
        """


class TimeHooks:
    """Any rule that decides may answer these, besides what it decides; each is asked on its own."""

    @hookspec(firstresult=True)
    def wake_at(self, warehouse: WarehouseView, rng: np.random.Generator) -> float | None:
        """Return the time of the next decision round, even if nothing happens until then, for example for waves.

        Called after each decision round; ``warehouse`` has the whole backlog. The earliest answer starts the next
        round, unless an event starts one before: then all are asked anew. This is no decision; observers are not told.

        Returns
        -------
        float | None
            Simulated seconds, later than ``warehouse.now_s``; the round is at the first tick that is not earlier;
            None for no such round. A run with 100,000 such rounds in a row and no event stands still.
        """


class ObserverHooks:
    """Every registered observer is told everything. Metrics, tables, trace and display are observers too."""

    @hookspec
    def run_started(self, run: RunInfo) -> None:
        """A run begins.

        Parameters
        ----------
        run
            Scenario, instance, layout, the warehouse at time 0, and ``run.out``, a folder next to the results, where an
            observer may write files of its own.
        """

    @hookspec
    def on_event(self, event: Event) -> None:
        """Something happened.

        An observer with an attribute ``hears``, a tuple of event classes, is told of events of these classes only. If
        ``hears`` maps event classes to sequences of functions, these are called with the event instead of the hook,
        which the observer has to have all the same.

        Parameters
        ----------
        event
            One of the classes of `rmfs.events`; frozen.
        """

    @hookspec
    def rule_asked(self, question: Question) -> None:
        """A rule is about to be asked for a decision.

        Parameters
        ----------
        question
            The rule, its hook and its arguments (`rmfs_core.info.Question`).
        """

    @hookspec
    def rule_answered(self, question: Question, answer: object) -> None:
        """The rule that was asked has answered.

        Called before the kernel checks the answer; not called for a rule that raises.

        Parameters
        ----------
        question
            The question.
        answer
            The value returned.
        """

    @hookspec
    def measured(self) -> Mapping[str, float | None]:
        """Return the observer's metrics, which join the others in result.json.

        Called once, after ``run_ended``.

        Returns
        -------
        Mapping[str, float | None]
            Numbers by name, None for one that is not defined (a mean over nothing); names of letters, digits and
            underscores that no other metric has. The same run gives the same numbers.
        """

    @hookspec
    def run_ended(self, tick: int, status: str) -> None:
        """A run is over.

        Parameters
        ----------
        tick
            Simulated time at the end, in ticks (1 ms).
        status
            ``"complete"``, ``"horizon"`` (``run.until_s`` was reached with orders left), ``"partial"`` (interrupted) or
            ``"failed"``.
        """
