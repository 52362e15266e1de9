"""Examples of hooks that decide nothing, and of `plan_paths`; `hooks.md` shows them, the tests try them."""

from attrs import define, field

from rmfs import hookimpl
from rmfs.events import ItemPicked, RobotMoved
from rmfs_rules.sipp import Sipp
from rmfs_traffic import occupancy


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
