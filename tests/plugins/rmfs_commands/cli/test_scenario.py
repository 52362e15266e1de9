"""`rmfs scenario check|show|schema|list`."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main
from rmfs_core import run as simulate
from rmfs_core.scenario import load_scenario, shipped_scenarios
from rmfs_core.scenario.reading import shipped_folder
from rmfs_core.world import make_layout, parse_map

RULES = '[rules]\npoa = "pod-match"\npps = "demand"\n'

ENDLESS = """
from attrs import define
from rmfs_core import hookimpl

@define
class Endless:
    needs = ("unlimited stock",)

    @hookimpl
    def assign_orders(self, warehouse):
        return []
"""

WRONG = [
    # reading
    ("[robots]\ncuont = 3\n" + RULES, "Error: {file}, line 2, robots.cuont: unknown key (did you mean `count`?)\n"),
    # the instance
    (
        '[instance]\norders_file = "no.csv"\npods_file = "no.csv"\n' + RULES,
        "Error: {file}, line 2, instance.orders_file: there is no file {folder}/no.csv\n",
    ),
    # pods, robots and stations against the layout
    (
        "[layout]\nstations_east = 2\n[stations]\nitem_capacity = [15, 15, 15]\n" + RULES,
        "Error: {file}, line 4, stations.item_capacity: found 3 capacities, but the layout has 2 picking stations\n",
    ),
]


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Run a command; return its exit code, output and errors."""
    code = 0
    try:
        main(list(arguments))
    except SystemExit as stop:
        code = int(stop.code or 0)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_check_says_what_is_wrong(text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A wrong scenario is one sentence on the error stream and exit code 2."""
    file = tmp_path / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    expected = message.replace("{file}", str(file)).replace("{folder}", str(tmp_path))
    assert run(capsys, "scenario", "check", str(file)) == (2, "", expected)


def test_check_says_what_a_rule_needs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A rule that relies on what the scenario lacks is named with its place."""
    (tmp_path / "endless.py").write_text(ENDLESS, encoding="utf-8")
    file = tmp_path / "wrong.toml"
    file.write_text(
        '[instance]\nitems_per_sku = 900\n[rules]\npps = "demand"\npoa = "endless.py:Endless"\n', encoding="utf-8"
    )
    code, out, err = run(capsys, "scenario", "check", str(file))
    assert (code, out) == (2, "")
    assert err.endswith(
        f'Error: {file}, line 5, rules.poa: rule "endless.py:Endless" (endless.py inline) needs pods whose SKUs '
        "never run out, but the instance has finite stock\n"
    )


def test_check_finds_wrong_parameters_of_rules(capsys: pytest.CaptureFixture[str]) -> None:
    """A parameter that a rule does not have is found without a run, with the place it came from."""
    code, out, err = run(capsys, "scenario", "check", "paper-250", "--set", "rules.poa.wieght=1")
    assert (code, out) == (2, "")
    assert err.startswith("Error: --set rules.poa.wieght=1: ")
    assert "Traceback" not in err


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_pass(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Every shipped scenario could be run as it is; a column that is left out is named once a process."""
    code, out, err = run(capsys, "scenario", "check", name)
    assert code == 0
    assert all(": ignored `" in line for line in err.splitlines())
    assert out.startswith(f"{name} is valid: ")


def test_check_names_an_order_that_comes_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two orders of one name are one, which is valid, and said with the line."""
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\no1,0,a,1\no2,0,a,1\no1,0,a,1\n")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,9\n")
    files = [f"instance.{kind}_file={tmp_path / kind}.csv" for kind in ("orders", "pods")]
    code, out, err = run(capsys, "scenario", "check", "examples/small", "--set", files[0], "--set", files[1])
    assert code == 0
    assert out.startswith("examples/small is valid: 2 orders of 3 items, ")
    assert err == (
        f"{tmp_path}/orders.csv, line 4: order o1 appears again after rows of other orders, "
        "and its rows are read as one order.\n"
    )


def test_check_says_that_it_loads_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Code from a file beside the scenario is announced, and refused on request."""
    (tmp_path / "mine.py").write_text(
        "from attrs import define\n"
        "from rmfs_core import hookimpl\n\n\n"
        "@define\n"
        "class Mine:\n"
        "    @hookimpl\n"
        "    def assign_orders(self, warehouse):\n"
        "        return ()\n",
        encoding="utf-8",
    )
    file = tmp_path / "mine.toml"
    file.write_text('[rules]\npoa = "./mine.py:Mine"\npps = "demand"\n', encoding="utf-8")
    code, _, err = run(capsys, "scenario", "check", str(file))
    assert (code, err) == (0, f"Loaded code from {tmp_path / 'mine.py'}.\n")
    code, _, err = run(capsys, "scenario", "check", "--no-inline-rules", str(file))
    assert code == 2
    assert err.startswith(f"Error: {file}, line 2, rules.poa: ")


def test_show_prints_the_resolved_scenario(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """What is printed is a scenario file again, equal to the one asked for."""
    code, out, _ = run(capsys, "scenario", "show", "examples/small", "--set", "robots.count=3", "--seed", "9")
    assert code == 0
    assert tomllib.loads(out)["seed"] == 9
    (tmp_path / "again.toml").write_text(out, encoding="utf-8")
    assert load_scenario(tmp_path / "again.toml") == load_scenario("examples/small", ["robots.count=3"], 9)


def test_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    """The schema goes to the output as JSON."""
    code, out, _ = run(capsys, "scenario", "schema")
    assert code == 0
    assert json.loads(out)["$schema"] == "https://json-schema.org/draft/2020-12/schema"


def test_list_names_the_shipped_scenarios(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each shipped scenario is a line with its name and what it is for, where there is room."""
    monkeypatch.setenv("COLUMNS", "400")
    code, out, _ = run(capsys, "scenario", "list")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()] == list(shipped_scenarios())
    assert all(len(line.split()) > 3 for line in out.splitlines())


def test_a_negative_seed_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A seed below 0 on the command line is exit code 2."""
    code, _, err = run(capsys, "scenario", "show", "paper-250", "--seed", "-1")
    assert code == 2
    assert "Traceback" not in err


def test_check_and_list_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    """What is wrong and where; the sizes when nothing is; names and files of what is shipped."""
    code, out, err = run(capsys, "scenario", "check", "examples/small", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["valid"]
    assert json.loads(out)["sizes"]["orders"] == 50
    code, out, err = run(capsys, "scenario", "check", "examples/small", "--json", "--set", "robots.count=0")
    assert (code, err) == (2, "")
    problem = "expected a whole number from 1 to 100,000, found 0"
    assert json.loads(out)["problems"] == [{"place": "--set robots.count=0", "problem": problem}]
    _, out, _ = run(capsys, "scenario", "list", "--json")
    assert [(one["name"], Path(one["file"])) for one in json.loads(out)] == list(shipped_scenarios().items())


@pytest.mark.parametrize("name", ["examples/small", "examples/text-map", "examples/example-appendix", "paper-250"])
def test_a_map_reads_back_as_the_same_layout(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Any scenario's layout can be drawn, changed in an editor and used as a text map."""
    code, out, err = run(capsys, "scenario", "map", name)
    assert (code, err) == (0, "")
    layout, again = make_layout(load_scenario(name)), parse_map(out, "map")
    assert (again.width, again.height, again.stations) == (layout.width, layout.height, layout.stations)
    assert (again.kind == layout.kind).all()
    assert (again.moves == layout.moves).all()


def test_a_map_follows_overrides(capsys: pytest.CaptureFixture[str]) -> None:
    """`--set` changes what is drawn."""
    _, out, _ = run(capsys, "scenario", "map", "examples/small", "--set", "layout.stations_east=1")
    assert out.count("O") == 1


def test_the_shipped_text_map_is_used() -> None:
    """It has a pillar among the blocks, and all of its orders are picked."""
    assert "####.@@@@.####" in (shipped_folder() / "examples" / "text-map-hall.txt").read_text(encoding="utf-8")
    result = simulate("examples/text-map")
    assert (result.status, result.metrics["orders_completed"]) == ("complete", 40)


def test_one_station_is_one_station(capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers and their words agree."""
    code, out, _ = run(capsys, "scenario", "check", "examples/small", "--set", "layout.stations_east=1")
    valid = "examples/small is valid: 50 orders of 130 items, 20 SKUs, 30 pods, 1 station, 4 robots.\n"
    assert (code, out.partition("Note:")[0]) == (0, valid)


def test_the_last_part_of_a_shipped_name_is_understood(capsys: pytest.CaptureFixture[str]) -> None:
    """Who leaves the folder out learns the whole name."""
    code, _, error = run(capsys, "scenario", "show", "small")
    assert code == 2
    assert error.endswith("no shipped scenario of that name (did you mean `examples/small`?)\n")


@pytest.mark.parametrize("width", [60, 80, 140])
def test_the_list_fits_the_screen(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    """Names are whole, and no line is wider."""
    monkeypatch.setenv("COLUMNS", str(width))
    code, out, _ = run(capsys, "scenario", "list")
    assert code == 0
    assert max(map(len, out.splitlines())) <= width
    first_words = [line.split()[0] for line in out.splitlines() if not line.startswith(" ")]
    assert first_words == list(shipped_scenarios())
