"""An example of each hook: a whole rule or observer, as `hooks.md` shows them and the tests try them."""

from attrs import define, field

from rmfs_core import JointDecision, OrderAssignment, Path, PodTrip, TaskAssignment, hookimpl
from rmfs_core.events import ItemPicked, RobotMoved
from rmfs_core.rule_helpers import send_pods


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
        return send_pods(warehouse, max_fetches, lambda station, pods: pods[0])


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
