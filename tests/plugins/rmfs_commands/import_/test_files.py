"""`rmfs import`: which format files have, how XML is read, and what then runs."""

import json
import shlex
from pathlib import Path

import pytest

from calling import refusal, refused
from cases import cases
from rawsimo_files import keys, xgenc, xinst, xsett
from rmfs_commands.cli.main import main
from rmfs_commands.import_ import xml_reading
from rmfs_commands.import_.kinds import kind_of, sorted_out
from rmfs_commands.import_.xml_reading import document, elements, root_name
from rmfs_commands.layouts import parse_map
from rmfs_core.errors import InputError

ORDERS = """<?xml version="1.0"?>
<List Type="a">
  <Orders>
    <Order Time="1.5"><Lines><Line SKU="7" /></Lines></Order>
    <Order Time="2" />
  </Orders>
  <Name> some &amp; any </Name>
</List>
"""


def file(folder: Path, text: str | bytes) -> Path:
    path = folder / "orders.xitem"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_elements_and_values(tmp_path: Path) -> None:
    first, second = elements(file(tmp_path, ORDERS), 2)
    assert (first.name, first.above, first.line, first.number("Time")) == ("Order", ("List", "Orders"), 4, 1.5)
    assert [line.whole("SKU") for line in first.inside[0].inside] == [7]
    assert (second.place, second.inside) == (f"{tmp_path}/orders.xitem, line 5", [])
    root = document(file(tmp_path, ORDERS))
    assert (root.value("Type"), root.value("Name"), root.value("Other")) == ("a", "some & any", None)
    assert (root.number("Other", 3.5), root.whole("Other", 4), root.truth("Other", True)) == (3.5, 4, True)
    with pytest.raises(InputError, match=r"orders.xitem, line 2: expected a whole number .* of List, found nothing"):
        root.whole("Other")


@cases(
    "value problem",
    ("x", "expected a number from 0 to 10 as `N` of A, found 'x'"),
    ("11", "found '11'"),
    ("NaN", "found 'NaN'"),
    ("1e999", "found '1e999'"),
    ("", "found nothing"),
)
def test_wrong_numbers_are_told_with_their_line(tmp_path: Path, value: str, problem: str) -> None:
    root = document(file(tmp_path, f"<A>\n<N>{value}</N></A>"))
    said = refusal(lambda: root.number("N", least=0, most=10))
    assert said.startswith(f"{tmp_path}/orders.xitem, line 2: ")
    assert problem in said


@pytest.mark.parametrize("value", ["1.0", "-1", "1" * 30, "yes"])
def test_whole_numbers_and_truth_values_are_strict(tmp_path: Path, value: str) -> None:
    root = document(file(tmp_path, f"<A><N>{value}</N></A>"))
    with pytest.raises(InputError, match="expected a whole number"):
        root.whole("N")
    with pytest.raises(InputError, match="expected true or false"):
        root.truth("N", False)


BOMB = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>'


@cases(
    "text problem",
    ("<a><b></a>", "line 1: this is no valid XML: mismatched tag"),
    ("", "line 1: this is no valid XML: no element found"),
    ("no XML", "line 1: this is no valid XML: syntax error"),
    ('<?xml version="1.0" encoding="klingon"?><a/>', "this is no valid XML: unknown encoding"),
    (BOMB, "found a document type (DOCTYPE); expected none"),
    ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', "found a document type (DOCTYPE); expected none"),
    ("<a>" * 40, "found more than 30 elements in one another; expected fewer"),
)
def test_what_is_no_such_file_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    assert problem in refusal(lambda: document(file(tmp_path, text)))


def test_there_are_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    many = "<a><b>" + "<c/>" * 200 + "</b></a>"
    monkeypatch.setattr(xml_reading, "MOST_IN_ONE", 100)
    with pytest.raises(InputError, match="found more than 100 elements and signs in one element"):
        list(elements(file(tmp_path, many), 1))
    assert len(list(elements(file(tmp_path, "<a>" + "<b/>" * 200 + "</a>"), 1))) == 200
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 100)
    with pytest.raises(InputError, match="found more than 100 bytes without an element"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 10**9)
    monkeypatch.setattr(xml_reading, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match="found more than 1,000 bytes"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))


def test_a_file_is_there_and_begins_with_its_element(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none: cannot be read: No such file"):
        document(tmp_path / "none")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        document(tmp_path)
    assert root_name(b'\xef\xbb\xbf<?xml version="1.0"?>\n<Instance Name="x"><Bots>') == "Instance"
    assert root_name(b"type octile\n") is None
    assert root_name(b"") is None


OCTILE = "type octile\nheight 1\nwidth 2\nmap\n..\n"
TEXTS = {
    "a.xinst": keys("Instance", {}),
    "a.xsett": keys("SettingConfiguration", {}),
    "a.map": OCTILE,
    "b.map": OCTILE.replace("..\n", ".E\n"),
    "k.map": "1,2\n0\n0\n0\n..\n",
    "s.grid": "Grid size (x, y)\n1,1\n",
    "a.scen": "version 1\n",
    "a.json": '\ufeff {"mapFile": "a.map"}',
    "a.txt": "hello\n",
    "a.html": "<html></html>",
    "broken.xinst": '<?xml version="1.0"?>\n<Instance Name="A & B"></Instance>',
    "empty": "",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@cases(
    "name found",
    ("a.txt", "found none of these"),
    ("a.html", "found an XML file of html"),
    ("broken.xinst", "broken.xinst, line 2: this is no valid XML: not well-formed"),
    ("empty", "found none of these"),
    ("none", "cannot be read: No such file or directory"),
    (".", "cannot be read: Is a directory"),
)
def test_other_files_are_refused(folder: Path, name: str, found: str) -> None:
    assert found in refusal(lambda: kind_of(folder / name))


@cases(
    "names asked chosen",
    (["a.xsett", "a.xinst"], None, "rawsim-o"),
    (["k.map"], None, "rhcr"),
    (["s.grid"], "rhcr", "rhcr"),
    (["a.json"], None, "lorr"),
    (["a.map"], None, "movingai"),
    (["b.map"], None, "lorr"),
    (["a.map"], "lorr", "lorr"),
    (["b.map"], "movingai", "movingai"),
    (["a.map", "a.scen"], None, "movingai"),
)
def test_files_of_one_instance_have_one_format(folder: Path, names: list[str], asked: str | None, chosen: str) -> None:
    assert sorted_out([folder / name for name in names], asked)[0] == chosen


@cases(
    "names asked message",
    (["a.map", "b.map"], None, "a.map, too, which is of the same kind; expected one of them"),
    (["a.map", "a.xinst"], None, "a.map and a.xinst: found files of different formats, or one missing; expected"),
    (["a.scen"], None, "a.scen: found files of different formats, or one missing"),
    (["k.map"], "lorr", "--format: found files that the League of Robot Runners does not have together; they look"),
    (["a.map", "a.xinst"], "rhcr", "--format: found files that RHCR does not have together"),
)
def test_files_that_do_not_belong_together_are_refused(folder, names, asked, message) -> None:
    assert message in refusal(lambda: sorted_out([folder / name for name in names], asked))


HALL = ".......\n.##.##.\n.......\n.##→→→O\n.......\n"
ENDPOINTS = "type octile\nheight 3\nwidth 6\nmap\n......\n.E@@S.\n......\n"
KIVA = "3,6\n2\n2\n5000\n......\nr.ee.r\n......\n"
PROBLEM = {"mapFile": "a.map", "agentFile": "a.agents", "taskFile": "a.tasks", "teamSize": 2}
INSTANCES = {
    "hall.xinst": xinst(parse_map(HALL, "hall"), {0: (2, 2), 1: (4, 3)}, [(1, 1)]),
    "few.xsett": xsett(run={"SimulationDuration": 200}, InitialInventory=0.2),
    "few.xgenc": xgenc({0: 1, 1: 2}),
    "kiva.map": KIVA,
    "a.map": ENDPOINTS,
    "a.agents": "2\n0\n12\n",
    "a.tasks": "2\n7,10\n10,7\n",
    "a.json": json.dumps(PROBLEM),
    "m.map": ENDPOINTS.replace("E", "."),
    "m.scen": "version 1\n0\tm.map\t6\t3\t0\t0\t5\t2\t8\n1\tm.map\t6\t3\t5\t0\t0\t2\t8\n",
}


@pytest.fixture
def instances(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in INSTANCES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@cases(
    "files kind wrote",
    (
        ["hall.xinst", "few.xsett", "few.xgenc"],
        "RAWSim-O",
        ["import.json", "map.txt", "orders.csv", "pods.csv", "robots.csv", "scenario.toml"],
    ),
    (["kiva.map"], "RHCR", ["import.json", "map.txt", "trips.scen"]),
    (["a.json"], "League of Robot Runners", ["import.json", "map.txt", "trips.scen"]),
    (["m.map", "m.scen"], "MovingAI", ["import.json", "map.txt", "trips.scen"]),
)
def test_the_command_that_is_shown_runs(instances, capsys, files, kind, wrote) -> None:
    main(["import", *files, "--out", "made"])
    said = capsys.readouterr().out
    assert said.startswith(f"Read from {kind}: ")
    assert sorted(file.name for file in (instances / "made").iterdir()) == wrote
    assert f"Wrote {', '.join(wrote)} to made." in said
    arguments = said.splitlines()[-1].removeprefix("Run it with: rmfs ").split()
    main([*arguments, *(["--quiet", "--out", "run"] if arguments[0] == "run" else ["--pp", "free-flow"])])
    assert ("Arrived 2 of 2" in capsys.readouterr().out) == (arguments[0] == "plan")
    assert (instances / "run" / "result.json").exists() == (arguments[0] == "run")


def test_the_command_that_is_shown_can_be_pasted(instances: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["import", "m.map", "--out", "my {} map"])
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("Run it with: rmfs "))
    assert words == ["plan", "my {} map/map.txt", "--agents", "8"]
    main([*words, "--pp", "free-flow"])
    assert "8 robots, free-flow" in capsys.readouterr().out


def test_the_report_is_json_too(instances: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["import", "kiva.map", "--out", "made", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told.pop("folder") == "made"
    assert told == json.loads((instances / "made" / "import.json").read_text(encoding="utf-8"))
    assert (told["format"], told["read"]["trips"]) == ("RHCR", 2)
    assert told["without_counterpart"][0] == {"what": "endpoints (e)", "number": 2, "instead": "storage locations"}
    main(["import", "kiva.map", "--out", "again", "--json"])
    for file in (instances / "made").iterdir():
        assert file.read_bytes() == (instances / "again" / file.name).read_bytes()


@cases(
    "arguments message",
    (["m.scen"], "Error: m.scen: found files of different formats, or one missing; expected those of one instance"),
    (["none.xinst"], "Error: none.xinst: cannot be read: No such file or directory"),
)
def test_wrong_files_are_one_sentence(instances, capsys, arguments, message) -> None:
    said = refused(capsys, main, ["import", *arguments, "--out", "made"])
    assert said.startswith(message)
    assert len(said.splitlines()) == 1
    assert not (instances / "made").exists()


def test_files_are_replaced_when_asked(instances: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["import", "kiva.map", "--out", "made"])
    told = refused(capsys, main, ["import", "kiva.map", "--out", "made"])
    assert "found a file of that name; --force replaces it" in told
    main(["import", "kiva.map", "--out", "made", "--force", "--seed", "2"])
    assert (instances / "made" / "trips.scen").exists()
