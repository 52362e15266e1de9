"""An example of each hook: a whole rule or observer, as `hooks.md` shows them and the tests try them."""

from attrs import define, field

from rmfs import (
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
    hookimpl,
)
from rmfs.events import ItemPicked, RobotMoved
from rmfs.helpers import send_pods
from rmfs_rules.sipp import Sipp
from rmfs_traffic import occupancy


@define
class OldestThatFits:
    @hookimpl
    def assign_orders(self, warehouse):
        for order in warehouse.backlog:
            for station in warehouse.stations:
                if warehouse.fits(order, station):
                    return [OrderAssignment(order.id, station.id)]  # one at a time: it is asked again
        return []


@define
class FirstPod:
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return send_pods(warehouse, max_fetches, lambda station, pods, wanted: pods[0])


@define
class OldestWithItsPods:
    needs = ("unlimited stock",)

    @hookimpl
    def assign_orders_and_pods(self, warehouse):
        for order in warehouse.backlog:
            for station in warehouse.stations:
                if warehouse.fits(order, station):
                    there = {sku for pod in station.inbound_pods for sku in pod.contents}
                    missing = [line.sku for line in order.open_lines if line.sku not in there]
                    pods = {warehouse.pods_with(sku)[0].id for sku in missing}
                    trips = [PodTrip(pod, station.id) for pod in sorted(pods)]
                    return JointDecision([OrderAssignment(order.id, station.id)], trips)
        return JointDecision()


@define
class AnyPlace:
    @hookimpl
    def choose_storage_location(self, warehouse, rng):
        return rng.choice(warehouse.free_storage_locations)


@define
class FirstRobot:
    @hookimpl
    def assign_tasks(self, warehouse):
        pairs = zip(warehouse.idle_robots, warehouse.waiting_pods)
        return [TaskAssignment(robot.id, pod.id) for robot, pod in pairs]


@define
class Fastest:
    @hookimpl
    def plan_path(self, warehouse, robot, goal):
        loaded = robot.pod is not None
        return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, loaded))


@define
class InTurn:
    reserves = "fleet"

    @hookimpl
    def plan_paths(self, queries, traffic):
        table, paths = traffic.table.copy(), {}
        for query in queries:
            if query.robot in traffic.arrives:
                continue  # it may keep its path
            path = Sipp().search(traffic.roads, table, query)
            if path is not None:
                table.release(query.robot)
                if query.robot in traffic.under_way:
                    table.add(query.robot, traffic.under_way[query.robot])
                table.add(query.robot, occupancy(traffic.roads, path))
                paths[query.robot] = path.path
        return paths


@define
class FirstPlace:
    @hookimpl
    def assign_bundles(self, warehouse):
        for station in warehouse.replenishment_stations:
            if station.free_bundle_capacity > 0:
                return [BundleAssignment(warehouse.bundles[0].id, station.id)]
        return []


@define
class FirstWithRoom:
    @hookimpl
    def select_replenishment_pods(self, warehouse, max_fetches):
        waiting = [b for station in warehouse.replenishment_stations for b in station.bundles if b.pod is None]
        pods = [pod for pod in warehouse.free_pods if max_fetches and pod.free_space >= waiting[0].size]
        return [StoreBundle(waiting[0].id, pods[0].id)] if pods else []  # one at a time


@define
class OldestWithItsPod:
    @hookimpl
    def assign_bundles_and_pods(self, warehouse, max_fetches):
        for station in warehouse.replenishment_stations:
            for bundle in warehouse.bundles[: station.free_bundle_capacity]:
                for pod in warehouse.free_pods[:max_fetches]:
                    if pod.free_space >= bundle.size:
                        chosen = BundleAssignment(bundle.id, station.id), StoreBundle(bundle.id, pod.id)
                        return BundleDecision(*([one] for one in chosen))
        return BundleDecision()


@define
class MoreForMore:
    @hookimpl
    def activate_stations(self, warehouse):
        """One station for every ten orders that wait, the largest ones first, and one in any case."""
        staffed = [station for station in warehouse.stations if station.staffed]
        staffed.sort(key=lambda station: -station.capacity)
        return [station.id for station in staffed[: 1 + len(warehouse.backlog) // 10]]


@define
class UnderNoPod:
    needs = ("no batteries",)  # it sends no robot to a charger

    @hookimpl
    def idle_robots(self, warehouse):
        free = [cell for cell in warehouse.free_rest_cells if cell in warehouse.free_storage_locations]
        beneath = [robot for robot in warehouse.idle_robots if robot.cell not in warehouse.free_storage_locations]
        return [RobotMove(robot.id, cell) for robot, cell in zip(beneath, free)]


@define
class WantedToTheFront:
    @hookimpl
    def move_pods(self, warehouse, max_moves):
        wanted = warehouse.open_demand()
        pods = [pod for pod in warehouse.free_pods if pod.robot is None and any(wanted[sku] for sku in pod.contents)]
        free = warehouse.free_storage_locations[:max_moves]  # in the north of the grid, say
        return [PodMove(pod.id, cell) for pod, cell in zip(pods, free) if cell < pod.cell]


@define
class OneAfterAnother:
    @hookimpl
    def assign_packing(self, warehouse, orders):
        chosen, free = [], [station.free_boxes for station in warehouse.packing_stations]
        for order in orders:
            able = [at for at, number in enumerate(free) if number or not order.split]
            chosen.append(able[order.id % len(able)])
            free[chosen[-1]] -= order.split
        return chosen


@define
class UrgentFirst:
    @hookimpl
    def choose_packing_task(self, tasks):
        return max(range(len(tasks)), key=lambda at: tasks[at].order.priority)


@define
class TwentyOldest:
    @hookimpl
    def filter_backlog(self, orders):
        return orders[:20]


@define
class Waves:
    wave_s: float = 900

    @hookimpl
    def filter_backlog(self, warehouse, orders):
        latest = warehouse.now_s // self.wave_s * self.wave_s
        return [order for order in orders if order.arrival_s <= latest]

    @hookimpl
    def wake_at(self, warehouse):
        return (warehouse.now_s // self.wave_s + 1) * self.wave_s if warehouse.backlog else None


@define
class Announce:
    @hookimpl
    def run_started(self, run):
        print(len(run.instance.orders), "orders,", len(run.warehouse.robots), "robots")


@define
class CountPicks:
    picks: int = 0

    @hookimpl
    def on_event(self, event):
        if isinstance(event, ItemPicked):
            self.picks += 1


@define
class CountQuestions:
    asked: int = 0

    @hookimpl
    def rule_asked(self, question):
        self.asked += 1


@define
class LastAnswers:
    answers: dict = field(factory=dict)

    @hookimpl
    def rule_answered(self, question, answer):
        self.answers[question.rule] = answer


@define
class Legs:
    driven: int = 0

    @hookimpl
    def on_event(self, event):
        if isinstance(event, RobotMoved):
            self.driven += 1

    @hookimpl
    def measured(self):
        return {"legs_driven": self.driven}


@define
class SayWhen:
    @hookimpl
    def run_ended(self, tick, status):
        print(f"{status} after {tick / 1000:.0f} s")
