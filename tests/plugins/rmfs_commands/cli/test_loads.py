"""Load before a run: work of the orders, and time for it."""

import math
from collections.abc import Mapping
from typing import Any

import pytest
from attrs import evolve

from calling import exit_code
from cases import cases
from replenished import scenario_of
from rmfs_commands.cli.loads import Demand, Load, load_line, load_sentences, load_warnings, loads, loads_of
from rmfs_commands.testing import small_layout
from rmfs_core.scenario import Scenario, load_scenario
from rmfs_core.scenario.model import RobotsSection, RuleChoice, RulesSection, RunSection, StationsSection
from rmfs_core.world import make_instance, make_layout

H = 3_600_000
RULES = RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))

BEGUN = {"line_s": 45.0, "order_s": 900.0, "speed": {"1": 2.0}}


def reckoned(items: Mapping[int, int], stations: int = 3, **keys: Any) -> tuple[Load, ...]:
    """Return the loads, by orders in the middle of hours, of pickers for 60 items an hour each, and of robots."""
    demand = Demand()
    for hour, number in items.items():
        demand.add(hour * H + H // 2, number, number, 1)
    section = StationsSection(pick_s=60, handle_s=60, open=keys.get("open"), **keys.get("begun", {}))
    robots = RobotsSection(count=stations, available=keys.get("available"))
    scenario = Scenario(rules=RULES, stations=section, robots=robots, run=RunSection(until_s=keys.get("until_s")))
    return tuple(loads_of(scenario, small_layout(stations), demand))


@cases(
    "items stations keys wanted_h there_h peak peak_percent done_h",
    # Each hour's orders count as there from its begin on for when all is done; nobody is asked after the last order
    ({8: 600, 18: 600}, 3, {}, 20, 30, "08:00", 1000 / 3, 18 + 10 / 3),
    # A wholesaler: 40 h of picking each
    ({6: 3600, 16: 3600}, 3, {}, 120, 30, "06:00", 2000, 6.5 + 40),
    # Closed at night: from 6 to 22, of which from half past six on counts
    ({6: 60, 12: 60}, 1, {"open": (("06:00", "22:00"),)}, 2, 15.5, "06:00", 100, 13),
    # What arrives after closing has so much of the next day as keeps the load, at most all; nobody is there in its hour
    ({20: 60, 23: 60}, 1, {"open": (("06:00", "22:00"),)}, 2, 3, "20:00", 100, 24 + 7),
    ({20: 60, 22: 2}, 1, {"open": (("06:00", "22:00"),)}, 62 / 60, 1.55, "20:00", 100, 24 + 6 + 2 / 60),
    ({20: 60, 30: 2}, 1, {"open": (("06:00", "22:00"),)}, 62 / 60, 2, "20:00", 100, 24 + 6 + 2 / 60),
    ({20: 60, 23: 900}, 1, {"open": (("06:00", "22:00"),)}, 16, 17.5, "20:00", 100, 24 + 21),
    ({21: 60, 23: 60}, 1, {"open": (("06:00", "22:00"),)}, 2, 16.5, "21:00", 100, 24 + 7.5),
    # Before they open at seven, orders arrive that the peak hour is not about
    ({6: 600, 7: 60, 8: 90}, 2, {"open": (("07:00", "22:00"),)}, 12.5, 30, "08:00", 75, 13.25),
    # The run ends at ten: two hours and a half of it are there
    ({7: 60, 9: 60}, 1, {"until_s": 36_000}, 2, 2, "07:00", 100, 10),
    ({7: 60, 11: 60}, 1, {"until_s": 36_000}, 2, 2.5, "07:00", 100, 12),
    # An hour's 60 items take 60 min, its 60 lines 45 and its order 15, all at twice the speed
    ({7: 60, 9: 60}, 1, {"until_s": 36_000, "begun": BEGUN}, 2, 2, "07:00", 100, 10),
    # All at once: there is no time in which it has to be done
    ({0: 900}, 3, {}, 15, None, None, None, 5.5),
)
def test_the_load_of_pickers(items, stations, keys, wanted_h, there_h, peak, peak_percent, done_h) -> None:
    pickers, _ = reckoned(items, stations, **keys)
    assert pickers.wanted_h == pytest.approx(wanted_h)
    assert pickers.there_h == (None if there_h is None else pytest.approx(there_h))
    assert (pickers.peak or "").partition(" ")[0] == (peak or "")
    assert pickers.peak_percent == (None if peak_percent is None else pytest.approx(peak_percent))
    assert pickers.done_h == pytest.approx(done_h)
    percent = None if there_h is None else 100 * wanted_h / there_h
    assert pickers.percent == (None if percent is None else pytest.approx(percent))
    if percent is not None:
        assert pickers.enough(percent) == math.ceil(stations * wanted_h / (there_h or 0))


@pytest.mark.parametrize("last", [13, 14, 15, 21])
def test_a_station_that_closes_early_adds_no_day(last: int) -> None:
    pickers, _ = reckoned({6: 60, last: 6}, 2, open={"1": (("06:00", "22:00"),), "2": (("06:00", "14:00"),)})
    assert pickers.there_h == 15.5 + 7.5


def test_what_is_said_of_too_much() -> None:
    much, trips = reckoned({6: 3600, 16: 3600})
    (warning, of_robots) = load_warnings((much, trips))
    assert warning == (
        "Warning: pickers have 120.0 h of work in 30.0 h. At least 12 stations are needed, 60 in the peak hour. "
        "The last item is handled about 46.5 h after time 0, or later."
    )
    assert "if each trip serves one order line" in of_robots
    assert of_robots.endswith("order lines each.")
    peak, _ = reckoned({6: 90, 16: 90}, 1)
    assert [*load_warnings([peak])] == [
        "Note: the orders of the hour from 06:00 bring 150 % of what pickers can do in it; "
        "at least 2 stations are needed then."
    ]
    fine, _ = reckoned({6: 30, 16: 30}, 1)
    assert not [*load_warnings([fine])]
    assert load_line([fine]) == "Load: pickers 10 % (50 % in the hour from 06:00)."
    assert load_line([]) == ""


def test_the_end_of_a_run_is_a_limit() -> None:
    scenario = load_scenario("examples/poisson", ["run.until_s=1800", "stations.handle_s=60"])
    instance = make_instance(scenario)
    pickers = loads(scenario, instance, make_layout(scenario))[0]
    early, every = (sum(order.items for order in instance.orders if order.arrival_tick < end) for end in (H / 2, 9 * H))
    assert early < every
    assert pickers.wanted_h == pytest.approx(early / 60)
    (note,) = load_warnings([pickers])
    assert note.startswith("Note: the run ends after 0.5 h (`run.until_s`), and pickers are not done before ")


@pytest.mark.parametrize(
    ("overrides", "there_h"), [((), 2 * 3 * 2.5), (('packing.open=[["00:00", "01:00"]]',), 2 * 3 * 0.5)]
)
def test_packers_have_a_load(overrides: tuple[str, ...], there_h: float) -> None:
    """Three at each of two stations pack an order of ten items in 40 s and 10 times 6 s."""
    keys = ("packing.packers=3", "packing.pack_s=40", "packing.pack_item_s=6", *overrides)
    scenario = load_scenario("examples/packing", keys)
    found = Demand()
    for minute in (30, 180):
        found.add(minute * 60_000, 10, 4, 1)
    (packers,) = [load for load in loads_of(scenario, make_layout(scenario), found) if load.who == "packers"]
    assert (packers.number, packers.wanted_h) == (6, pytest.approx(200 / 3600))
    assert packers.there_h == pytest.approx(there_h)
    assert "2 orders of 40 s, 20 items of 6 s, putting besides" in packers.work


def test_robots_on_duty_count() -> None:
    _, always = reckoned({8: 60, 18: 60})
    _, at_times = reckoned({8: 60, 18: 60}, available=(("08:30", "10:30", 2), ("12:30", "13:30", 1)))
    assert (always.there_h, at_times.there_h) == (30, 5)
    assert always.wanted_h == at_times.wanted_h > 2  # of picking, which holds a robot, too
    _, by_day = reckoned({8: 60, 58: 60}, open=(("06:00", "22:00"),))
    assert by_day.there_h == 3 * (13.5 + 16 + 16)  # nobody brings pods to stations that are closed at night
    _, never = reckoned({8: 60, 18: 60}, available=(("20:00", "21:00"),))
    assert never.percent == math.inf
    assert "none there" in "".join(load_sentences([never]))
    assert "At least" not in "".join(load_warnings([never]))


@pytest.mark.parametrize("also", [False, True])
def test_bundles_are_work_for_those_who_store_them(also: bool) -> None:
    """Ten bundles of ten items each replace what 104 of two SKUs leave below the reorder point."""
    supply = {"process": "reorder-point", "reorder_point": 2, "order_up_to": 12}
    scenario = scenario_of(supply, instance={"orders": 60, "skus": 2, "pods": 2, "skus_per_pod": 2, "items_per_sku": 2})
    if also:
        section = evolve(scenario.stations, also_replenish=True)
        layout = evolve(scenario.layout, replenishment_west=None)
        scenario = evolve(scenario, stations=section, layout=layout)
    instance = make_instance(scenario)
    found = loads(scenario, instance, make_layout(scenario))
    assert [load.who for load in found] == ["pickers", "robots", *([] if also else ["replenishment stations"])]
    assert ("bundles" in found[0].work) == also
    assert " and bundle" in found[1].work


def test_hours_out_of_service_are_none() -> None:
    """Stations are down for a tenth of the time, robots for a half and one of two for a quarter of the day besides."""
    often = ["stations.outages={mtbf_h=0.9, mttr_s=360}", "robots.failures={mtbf_h=1, mttr_s=3600}"]
    chargers = ["robots.battery.charger_outages={mtbf_h=3, mttr_s=3600}", "robots.count=2"]
    given = [*often, *chargers, 'robots.maintenance={1=[["00:00","03:00"], ["02:00","06:00"]]}']
    plain, fails = (load_scenario("examples/charging", overrides) for overrides in (["robots.count=2"], given))
    before, found = (loads(one, make_instance(one), make_layout(one)) for one in (plain, fails))
    shares = [now.there_h / load.there_h for now, load in zip(found, before, strict=True)]
    assert shares == pytest.approx([0.9, 0.5 * 7 / 8, 0.75])
    assert [load.down_percent for load in found] == pytest.approx([10, 56.25, 25])
    assert [load.wanted_h for load in found[:2]] == [load.wanted_h for load in before[:2]]
    assert found[0].done_h > before[0].done_h
    assert ", 10 % of the time out of service" in "".join(load_sentences(found))


def test_a_run_says_it_before_it_begins(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    slow = ("--set", "instance.orders=3", "--set", "rules.pp=free-flow")
    assert exit_code("run", "examples/small", *slow) == 0
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("Load: pickers ")
    assert first.endswith(" each.")
    assert exit_code("run", "examples/small", *slow, "--set", "instance.orders=0") == 0
    assert "Load" not in capsys.readouterr().err
