"""`rmfs benchmark`: the frozen set, claims, the table of best known values, and the search for better ones."""

import gzip
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.benchmark import claims, running, table
from rmfs_commands.benchmark.annealing import STOP, Work, cost
from rmfs_commands.benchmark.claims import (
    Claim,
    best_of,
    check_result,
    claim_line,
    read_claims,
    repeat,
    run_rules,
    without_beaten,
)
from rmfs_commands.benchmark.plans import plan_of
from rmfs_commands.benchmark.running import rules_given
from rmfs_commands.benchmark.scheduling import Problem
from rmfs_commands.benchmark.sets import OBJECTIVES, benchmark_set, known_bounds, made_checksum
from rmfs_commands.bounds import bounds_of
from rmfs_commands.cite.sources import SET_VERSION, cited
from rmfs_commands.cli import compiling
from rmfs_commands.cli.main import main
from rmfs_core.errors import InputError
from rmfs_core.scenario import scenario_to_dict
from rmfs_core.world import make_instance

SET = benchmark_set()
SMALLEST = SET.find("start-50-one")
EACH = [
    pytest.param(one, id=one.name, marks=() if one.scenario.instance.orders <= 250 else pytest.mark.slow)
    for one in SET.instances.values()
]


def claim(value: float, *, offline: bool = False, rule: str = "pod-index") -> Claim:
    return Claim("start-50-a", {"pod_station_visits": value}, {"poa_pps": rule}, "sha256:0", offline, {"rmfs": "1"})


@pytest.fixture(scope="module")
def run_of_smallest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run")
    run_rules(SMALLEST, {"poa_pps": "pod-index"}, out)
    return out


class TestSet:
    def test_it_has_instances_of_all_kinds(self) -> None:
        assert len(SET.instances) == 42
        assert SET.version == SET_VERSION
        scenarios = [one.scenario for one in SET.instances.values()]
        assert {one.instance.arrivals.process for one in scenarios} == {"start", "poisson", "day"}
        assert max(one.instance.orders for one in scenarios) == 20_000
        assert any(one.packing for one in scenarios)
        assert {name for one in SET.instances.values() for name in one.objectives} == {*OBJECTIVES}
        assert sum(one.scenario.instance.generator == "order-table" for one in SET.instances.values()) == 2

    @cases("one", *EACH)
    def test_instances_are_made_as_frozen(self, one: Any) -> None:
        assert made_checksum(one.scenario) == one.checksum

    def test_an_order_table_has_quantities_and_customers_who_come_back(self) -> None:
        shops, people = (make_instance(SET.find(f"table-{kind}").scenario) for kind in ("wholesale", "retail"))
        lines = [[line for order in one.orders for line in order.lines] for one in (shops, people)]
        items = [np.mean([quantity for _, quantity in of]) for of in lines]
        assert items[0] > 4
        assert items[1] < 2
        often = [np.bincount([sku for sku, _ in of]).max() / len(of) for of in lines]
        assert min(often) > 0.005  # uniform demand: 1/1200 and 1/2500

    @cases(
        "parameters said",
        ({"basket": 0.5}, "expected `customers` >= 1, `basket` from 1 to 30"),
        ({"customers": 0}, "expected `customers` >= 1"),
        ({"quantity": 900.0}, "the pods have too few items of SKU"),
    )
    def test_a_wrong_order_table_is_refused(self, parameters: Mapping[str, float], said: str) -> None:
        scenario = SET.find("table-wholesale").scenario
        wrong = attrs.evolve(scenario, instance=attrs.evolve(scenario.instance, parameters=parameters))
        assert said in refusal(lambda: make_instance(wrong))

    def test_names_may_end_in_a_star(self) -> None:
        chosen = [one.name for one in SET.chosen(["start-50-one", "table-*"])]
        assert chosen == ["start-50-one", "table-wholesale", "table-retail"]

    def test_a_failed_run_has_reached_nothing(self) -> None:
        row = {"status": "failed", "pod_station_visits": 0, "distance_m": 0.0}
        assert set(SMALLEST.reached(row).values()) == {None}
        assert SMALLEST.reached({**row, "status": "complete"})["pod_station_visits"] == 0


class TestClaims:
    def test_a_run_may_claim_what_its_trace_amounts_to(self, run_of_smallest: Path) -> None:
        result = json.loads((run_of_smallest / "result.json").read_text())
        found = check_result(run_of_smallest, SET)
        assert found.instance == "start-50-one"
        assert found.metrics == {name: result["metrics"][name] for name in SMALLEST.objectives}
        (run_of_smallest / "result.json").rename(run_of_smallest / "kept.json")
        assert check_result(run_of_smallest, SET).metrics == found.metrics  # nothing else counts
        (run_of_smallest / "kept.json").rename(run_of_smallest / "result.json")

    def test_another_instance_is_refused(self, tmp_path: Path) -> None:
        section = attrs.evolve(SMALLEST.scenario.robots, count=4)
        run_rules(attrs.evolve(SMALLEST, scenario=attrs.evolve(SMALLEST.scenario, robots=section)), {}, tmp_path)
        said = refusal(lambda: check_result(tmp_path, SET))
        assert "start-50-one has its seed, but its `robots` is not that of the instance" in said

    def test_a_changed_checksum_is_refused(self, run_of_smallest: Path) -> None:
        other = attrs.evolve(SMALLEST, checksum="sha256:0123")
        chosen = attrs.evolve(SET, instances={"start-50-one": other})
        assert "expected sha256:0123... of start-50-one" in refusal(lambda: check_result(run_of_smallest, chosen))

    def test_a_run_that_validate_refuses_is_refused(self, run_of_smallest: Path, tmp_path: Path) -> None:
        for name in ("trace.jsonl.gz", "result.json"):
            (tmp_path / name).write_bytes((run_of_smallest / name).read_bytes())
        result = json.loads((tmp_path / "result.json").read_text())
        result["metrics"]["pod_station_visits"] -= 1
        (tmp_path / "result.json").write_text(json.dumps(result))
        assert "`rmfs validate` finds 1 fault" in refusal(lambda: check_result(tmp_path, SET))

    def test_a_trace_that_calls_itself_a_real_day_is_refused(self, run_of_smallest: Path, tmp_path: Path) -> None:
        """Less is checked of these, so times might be any."""
        head, *events = gzip.decompress((run_of_smallest / "trace.jsonl.gz").read_bytes()).splitlines(keepends=True)
        head = json.dumps(json.loads(head) | {"floor": {"corrected_s": 0.0}}).encode() + b"\n"
        (tmp_path / "trace.jsonl.gz").write_bytes(gzip.compress(b"".join([head, *events])))
        assert "line 1, floor: the run is a real day" in refusal(lambda: check_result(tmp_path, SET))

    def test_moves_without_a_visit_are_refused(self) -> None:
        told = scenario_to_dict(SMALLEST.scenario) | {"rules": {"move": "any"}}
        assert "`rules.move`" in (SMALLEST.problem_with(told) or "")

    def test_the_best_is_the_least_and_of_equal_ones_not_offline(self) -> None:
        one = SET.find("start-50-a")
        claims = [claim(7, offline=True), claim(7, rule="lns"), claim(8)]
        assert best_of(claims, one)["pod_station_visits"].rules == {"poa_pps": "lns"}
        assert without_beaten(claims, SET) == [claims[1]]

    @cases(
        "changed said",
        ({"offline": "yes"}, "expected a claim, as"),
        ({"trace": 5}, "expected a claim, as"),
        ({"rules": {"poa_pps": {"rule": 5}}}, "expected a claim, as"),
        ({"rules": {"poa_pps": {"n": 5}}}, "expected a claim, as"),
        ({"rules": {"poa_pps": "nope"}}, 'there is no rule "nope"'),
        ({"instance": "nowhere"}, 'there is no instance "nowhere"'),
        ({"metrics": {"pod_station_visits": 5}}, "pod_station_visits 5 of start-50-a; no run can have less than 6"),
    )
    def test_a_wrong_claim_is_refused_with_its_line(self, changed: dict[str, Any], said: str, tmp_path: Path) -> None:
        file = tmp_path / "mine.jsonl"
        file.write_text(claim_line(claim(7)) + json.dumps(attrs.asdict(claim(7)) | changed) + "\n")
        told = refusal(lambda: read_claims(file))
        assert told.startswith(f"{file}, line 2: ")
        assert said in told

    def test_a_value_of_another_file_is_marked_as_unverified(self) -> None:
        (best,) = table.best_known([SET.find("start-50-a")], [claim(6, offline=True)])
        assert best.made_by == "pod-index (offline, unverified)"
        assert {best.verified for best in table.best_known([SMALLEST], CLAIMS)} == {True}

    @cases(
        "plan said",
        (None, "found a plan of another form; expected a list for each picking station"),
        ([[5]], "found a plan of another form"),
        ([[[0, [[0, "x"]]]]], "found a plan of another form"),
        ([[[999, [[0, 0]]]]], "takes SKU 0 of order 0 from pod 999, which does not hold it"),
        ([], "found a plan of another form"),
        ([[[0, [[0, 0]]]], []], "found 2 lists; expected 1, one a picking station"),
    )
    def test_a_damaged_plan_is_refused(self, plan: Any, said: str) -> None:
        rules = {"poa_pps": {"rule": "Replay", "plan": plan}}
        assert f"plan of start-50-one: {said}" in refusal(lambda: run_rules(SMALLEST, rules))

    def test_a_plan_that_leaves_out_a_line_is_refused(self) -> None:
        plan = best_of(CLAIMS, SMALLEST)["pod_station_visits"].rules["poa_pps"]["plan"]
        (pod, lines), *rest = plan[0]
        said = refusal(lambda: plan_of({"plan": [[(pod, lines[1:]), *rest]]}, SMALLEST.scenario, "p"))
        assert "0 times, expected 1" in said

    def test_another_trace_is_not_the_claim(self, run_of_smallest: Path, tmp_path: Path) -> None:
        known = attrs.evolve(check_result(run_of_smallest, SET), trace="sha256:0")
        assert "the run is another one" in refusal(lambda: repeat(known, SET, tmp_path))


class TestKnown:
    """Claims and bounds that come with the package are true."""

    def test_every_instance_has_a_value_of_each_objective(self) -> None:
        every = list(SET.instances.values())
        found = {(best.instance.name, best.objective) for best in table.best_known(every, CLAIMS)}
        assert found == {(one.name, name) for one in every for name in one.objectives}
        assert without_beaten(CLAIMS, SET) == CLAIMS

    def test_no_value_is_below_its_bound(self) -> None:
        gaps = [best.gap for best in table.best_known(list(SET.instances.values()), CLAIMS)]
        assert min(gap for gap in gaps if gap is not None) >= 0

    @cases("objective", "pod_station_visits", "turnover_s")
    def test_ten_static_instances_are_within_a_tenth_of_the_bound(self, objective: str) -> None:
        small = [one for one in SET.instances.values() if one.static and one.scenario.instance.orders <= 150]
        near = [best.gap for best in table.best_known(small, CLAIMS, [objective])]
        assert sum(gap is not None and gap <= 0.1 for gap in near) >= 10

    @cases("name", "start-50-a", "start-100-c", "stock-100")
    def test_bounds_are_those_of_rmfs_bound(self, name: str) -> None:
        one = SET.find(name)
        assert known_bounds()[name] == {bound.metric: bound.value for bound in bounds_of(one.scenario, one.objectives)}

    @cases(
        "name objective",
        ("start-50-one", "pod_station_visits"),
        ("start-50-a", "turnover_s"),
        pytest.param("start-100-a", "turnover_s", marks=pytest.mark.slow),
        pytest.param("stock-150", "pod_station_visits", marks=pytest.mark.slow),
        pytest.param("packing-60", "packed_s", marks=pytest.mark.slow),
        pytest.param("due-300", "late_orders", marks=pytest.mark.slow),
    )
    def test_claims_are_made_again(self, name: str, objective: str, tmp_path: Path) -> None:
        known = best_of(CLAIMS, SET.find(name))[objective]
        assert repeat(known, SET, tmp_path).metrics == known.metrics


CLAIMS = read_claims()


class TestSchedules:
    def test_the_evaluator_works_out_a_schedule_by_hand(self) -> None:
        """Two orders at one station: pod 0 has SKU 0, pod 1 SKU 1; fetching and carrying take 10 s each."""
        work = Work(
            order=np.array([0, 1, 1]), sku=np.array([0, 0, 1]), orders=2, stations=1, robots=1, capacity=5,
            stock=np.array([[9, 0], [0, 9]]), first=np.full((1, 2), 10.0), carry=np.full((2, 1), 10.0), store=5.0,
            swap=4.0, pick=7.0, handle=13.0, weights=np.array([1.0, 100.0, 0.0]),
        )  # fmt: skip
        # Pod 0 is there at 20, its two items are handled at 33 and 46; it leaves at 40, its robot is free at 45, and
        # the other pod is there at 65: its item is handled at 78.
        by_hand = getattr(cost, "py_func", cost)
        assert by_hand(np.array([0, 1, 2]), np.array([0, 0, 1]), work) == (33 + 78) / 2 + 200
        two = work._replace(robots=2, first=np.array([[20.0, 0.0], [4.0, 5.0]]))
        # The second robot is nearer to pod 0, and there at 14; the other pod is there then, and waits for the picker.
        assert by_hand(np.array([0, 1, 2]), np.array([0, 0, 1]), two) == (27 + 53) / 2 + 200

    @pytest.mark.slow  # it compiles the search
    def test_a_schedule_serves_each_line_once_and_annealing_keeps_that(self) -> None:
        problem = Problem.of(SET.find("stock-100"), "turnover_s")
        first = problem.first("turnover_s")
        better = problem.improved(first, seed=1, pace=1.0, steps=3000)
        for sequence, pod_of in (first, better):
            assert sorted(sequence.tolist()) == [STOP] * 3 + [*range(len(problem.work.sku))]
            taken = np.zeros_like(problem.work.stock)
            np.add.at(taken, (pod_of, problem.work.sku), 1)
            assert (taken <= problem.work.stock).all()
        assert cost(*better, problem.work) < cost(*first, problem.work)
        again = problem.improved(first, seed=1, pace=1.0, steps=3000)
        assert all((a == b).all() for a, b in zip(better, again, strict=True))

    @cases("name objective", ("poisson-100", "turnover_s"), ("packing-60", "turnover_s"), ("start-50-a", "late_orders"))
    def test_other_instances_and_objectives_have_none(self, name: str, objective: str) -> None:
        assert "there are no schedules of it" in refusal(lambda: Problem.of(SET.find(name), objective))


class TestCommand:
    def test_a_run_is_written_run_and_claimed(self, tmp_path, monkeypatch, capsys) -> None:
        monkeypatch.chdir(tmp_path)
        assert exit_code("benchmark", "write", "start-50-one") == 0
        assert exit_code("run", "start-50-one.toml", "--trace", "--quiet", "--out", "mine") == 0
        capsys.readouterr()
        assert exit_code("benchmark", "check", "mine", "--claims", "claims.jsonl") == 0
        shown = capsys.readouterr().out
        assert "start-50-one, pod-match + completes" in shown
        assert "Not added to claims.jsonl: each value is known, or a better one." in shown
        assert not Path("claims.jsonl").exists()
        monkeypatch.setattr(claims, "read_claims", lambda _=None: [])  # nothing is known
        assert exit_code("benchmark", "check", "mine", "--claims", "claims.jsonl") == 0
        assert "Added to claims.jsonl." in capsys.readouterr().out
        monkeypatch.undo()
        assert [one.instance for one in read_claims(tmp_path / "claims.jsonl")] == ["start-50-one"]

    def test_searches_of_each_kind_of_roads_are_compiled_before_the_runs(self, monkeypatch: pytest.MonkeyPatch) -> None:
        compiled: list[str] = []
        monkeypatch.setattr(compiling, "compile_searches", lambda _, scenario: compiled.append(scenario.rules.pp.rule))
        monkeypatch.setattr(running, "run_on", lambda *_, **__: compiled.append("runs"))
        assert exit_code("benchmark", "run", "start-50-*", "start-shared-50", "--rules", "poa_pps=pod-index") == 1
        assert sorted(compiled[:2]) == ["free-flow", "sipp"]
        assert compiled[2:] == ["runs"]

    @pytest.mark.slow
    def test_rules_run_on_instances_and_are_not_run_again(self, tmp_path: Path, capsys: Any) -> None:
        asked = ("start-50-o*", "start-50-a", "--rules", "poa_pps=pod-index", "--jobs", "1", "--json")
        call = ("benchmark", "run", *asked)
        assert exit_code(*call, "--out", str(tmp_path)) == 0
        runs = json.loads(capsys.readouterr().out)["runs"]
        assert {(row["scenario"], row["seed"]) for row in runs} == {("start-50-one", 4103), ("start-50-a", 4100)}
        figures = (tmp_path / "benchmark.json").read_bytes()
        assert exit_code(*call, "--out", str(tmp_path), "--table", str(tmp_path / "t.md")) == 0
        assert json.loads(capsys.readouterr().out)["runs"] == runs
        assert (tmp_path / "benchmark.json").read_bytes() == figures
        assert "| start-50-one | Visits | 10 | 7 | 42.9 % | 7 |" in (tmp_path / "t.md").read_text()
        assert {"rmfs-benchmark", "smith1956various"} <= {one.reference.key for one in cited([str(tmp_path)])}

    @pytest.mark.slow
    @cases("more", (), ("--parameters",))
    def test_a_search_leaves_a_claim(self, more: tuple[str, ...], tmp_path: Path, capsys: Any) -> None:
        call = ("benchmark", "improve", "start-50-one", "--objective", "turnover", "--minutes", "0", *more)
        assert exit_code(*call, "--out", str(tmp_path)) == 0
        assert "known before" in capsys.readouterr().out
        assert check_result(tmp_path, SET).metrics["turnover_s"] > 0

    def test_the_table_is_whole_in_80_columns(self, capsys: Any) -> None:
        assert exit_code("benchmark", "table") == 0
        assert "…" not in capsys.readouterr().out

    @cases("ending begins", (".csv", "Instance,Objective,"), (".tex", "\\begin{table"), (".md", "## Best known values"))
    def test_the_table_is_written(self, ending: str, begins: str, tmp_path: Path) -> None:
        assert exit_code("benchmark", "table", "start-50-*", "--table", str(tmp_path / f"t{ending}")) == 0
        assert (tmp_path / f"t{ending}").read_text().startswith(begins)

    @cases(
        "call said",
        (["table", "nowhere"], "nowhere: there is no such instance"),
        (["list", "nothing*"], "nothing*: no instance has a name that begins so"),
        (["table", "--table", "a.txt"], "expected a name that ends in .tex, .csv or .md"),
        (["check", "nowhere"], "nowhere"),
        (["repeat", "start-50-a", "--objective", "late", "--out", "x"], "no value of late_orders is known"),
        (["run", "start-50-a"], "expected KEY=RULE"),
        (["run", "start-50-a", "--rules", "foo"], "--rules foo: expected KEY=RULE, as in poa_pps=pod-index"),
    )
    def test_a_wrong_call_is_refused(self, call: list[str], said: str, capsys: Any, tmp_path: Path) -> None:
        assert said in " ".join(refused(capsys, main, ["benchmark", *call]).split())

    def test_rules_come_from_a_file_or_a_text(self, tmp_path: Path) -> None:
        file = tmp_path / "tuned.toml"
        file.write_text('[rules]\npoa_pps = { rule = "pod-index" }\n')
        assert rules_given([str(file), "pr=fixed"]) == {"poa_pps": {"rule": "pod-index"}, "pr": "fixed"}
        with pytest.raises(InputError, match="expected a section"):
            rules_given([str(Path(__file__).parents[4] / "scenarios" / "experiments" / "packing.toml")])
