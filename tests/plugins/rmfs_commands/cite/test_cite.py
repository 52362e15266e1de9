import json
import re
from email.message import Message
from pathlib import Path

import pytest
from attrs import define
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.cite import sources
from rmfs_commands.cite.bibtex import references_in, with_own_keys
from rmfs_commands.cite.sources import cited
from rmfs_commands.cli.main import main
from rmfs_core import hookimpl
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_rules.switch import Case, Switch

CITATION = Path(__file__).parents[4] / "CITATION.cff"


def test_bibtex_json_and_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    main(["cite", "pod-index"])
    printed = capsys.readouterr().out
    assert printed.startswith("% rmfs\n@misc{rmfs,\n  author = {{The rmfs authors}},\n")
    assert "% pod-index: how the largest ratio is found\n@article{dinkelbach1967nonlinear,\n" in printed
    main(["cite", "pod-index", "--json"])
    found = {one["key"]: one for one in json.loads(capsys.readouterr().out)}
    assert found["dinkelbach1967nonlinear"]["rules"] == {"pod-index": "how the largest ratio is found"}
    assert found["dinkelbach1967nonlinear"]["fields"]["year"] == "1967"
    assert exit_code("cite", "nothing-of-it") == 2
    assert capsys.readouterr().err == (
        'Error: rmfs cite: found "nothing-of-it"; expected a rule, a scenario, an experiment, the folder of a '
        "run, a comparison or benchmark runs, or benchmark\n"
    )


def test_an_experiment_and_its_folder_have_the_sources_of_all_their_rules(tmp_path: Path) -> None:
    scenario = load_scenario("examples/small", ["instance.orders=3"])
    file = tmp_path / "mine.toml"
    file.write_text(
        'base = "examples/small"\nseeds = [1]\nbaseline = "a"\naxes = { instance.orders = [3] }\n'
        '[[rule_sets]]\nname = "a"\n[[rule_sets]]\nname = "b"\nrules.poa_pps = "pod-index"\n',
        encoding="utf-8",
    )
    rmfs_core.run(scenario, out=tmp_path / "out" / "runs" / "1")
    of_file, of_folder = (
        {name for one in cited([str(what)]) for name in one.rules} for what in (file, tmp_path / "out")
    )
    assert {"rmfs", "pod-match", "demand", "pod-index"} <= of_file
    assert {"rmfs", "pod-match", "demand"} <= of_folder
    assert "pod-index" not in of_folder


def test_a_file_of_rules_alone_has_the_sources_of_these(tmp_path: Path) -> None:
    """Which rules decide the rest depends on the scenario that it is for."""
    file = tmp_path / "tuned.toml"
    file.write_text('[rules]\npoa_pps = { rule = "pod-index" }\n', encoding="utf-8")
    assert {name for one in cited([str(file)]) for name in one.rules} == {"rmfs", "pod-index"}


def test_a_release_has_its_year_and_the_project_its_address(monkeypatch: pytest.MonkeyPatch) -> None:
    released = re.search(r"^version: (.+)\ndate-released: (\d+)", CITATION.read_text(encoding="utf-8"), re.MULTILINE)
    assert released is not None
    monkeypatch.setattr(sources, "version", lambda _: released[1])
    monkeypatch.setattr(sources, "metadata", lambda _: Message())
    assert cited([])[0].reference.fields["year"] == released[2]
    monkeypatch.setattr(sources, "version", lambda _: f"{released[1]}.dev0")
    entry = cited([])[0].reference
    assert (entry.fields["note"], entry.fields["year"], entry.fields["url"]) == (f"Version {released[1]}.dev0", "", "")
    assert "year" not in entry.bibtex()
    found = Message()
    found["Project-URL"] = "Repository, https://example.org/rmfs"
    monkeypatch.setattr(sources, "metadata", lambda _: found)
    assert "  url = {https://example.org/rmfs},\n" in cited([])[0].reference.bibtex()


HOSTILE = r'''
from attrs import define
from rmfs_core import hookimpl
@define
class Hostile:
    r"""POA: nothing.
    References
    ----------
    A. Bee: On honey { wax. Hive, 2001. https://doi.org/10.1000/a\b (as @article{in, year} has it)
    """
    @hookimpl
    def assign_orders(self, warehouse):
        return []
'''


def test_a_docstring_writes_no_entries(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hostile.py").write_text(HOSTILE, encoding="utf-8")
    Path("mine.toml").write_text('[rules]\npoa = "./hostile.py:Hostile"\npps = "demand"\n', encoding="utf-8")
    main(["cite", "mine.toml"])
    printed = capsys.readouterr().out
    main(["cite", "./hostile.py:Hostile"])
    assert capsys.readouterr().out == printed.partition("% demand\n")[0]
    assert "% ./hostile.py:Hostile: as (at)article{in, year} has it\n@misc{bee2001honey,\n" in printed
    assert "  title = {On honey \\textbraceleft{} wax},\n" in printed
    assert "  doi = {10.1000/a%5Cb},\n" in printed


def keys(*what: str) -> dict[str, list[str]]:
    return {one.reference.key: list(one.rules) for one in cited(what)}


def test_rules_of_scenarios_and_runs(tmp_path: Path) -> None:
    found = keys("pod-match", "demand", "pod-match")
    assert next(iter(found)) == "rmfs"
    assert found["xie2019efficient"] == found["merschformann2019decision"] == ["pod-match", "demand"]
    (tmp_path / "mine.py").write_text(HOSTILE, encoding="utf-8")
    switch = '{ rule = "switch", cases = [{ rule = "nearest-pod", before_s = 60 }, { rule = "demand" }] }'
    scenario = f'[rules]\npoa = "./mine.py:Hostile"\npps = {switch}\n'
    (tmp_path / "mine.toml").write_text(scenario, encoding="utf-8")
    found = keys(str(tmp_path / "mine.toml"))
    assert len(found["bee2001honey"]) == 1
    assert {"nearest-pod", "demand"} <= {*found["merschformann2019decision"]}
    assert "switch" in found["merschformann2018rawsimo"]
    rules = {"poa": "pod-match", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "sipp"}
    result = {"scenario": {"rules": rules}, "metrics": {}}
    (tmp_path / "result.json").write_text(json.dumps(result), encoding="utf-8")
    assert keys(str(tmp_path))["ma2019lifelong"] == ["sipp"]
    rules = {"poa": "./gone.py:Mine", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "sipp"}
    (tmp_path / "result.json").write_text(json.dumps({"scenario": {"rules": rules}, "metrics": {}}), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^{re.escape(str(tmp_path))}, rules\.poa: rule .*: cannot read .*gone\.py"):
        cited([str(tmp_path)])


def test_a_run_whose_rule_was_an_object(tmp_path: Path) -> None:
    @define
    class Own:
        @hookimpl
        def idle_robots(self) -> list[object]:
            return []

    settings = ["instance.orders=3", "rules.pp=free-flow"]
    rmfs_core.run(load_scenario("examples/small", settings), rules={"idle": Own()}, out=tmp_path / "own")
    with pytest.raises(InputError) as caught:
        cited([str(tmp_path / "own")])
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f'{tmp_path / "own"}, rules.idle: found rule "Own", expected one that is inst')
    switch = Switch(cases=(Case("pod-match", before_s=60), Case("random")))
    rmfs_core.run(load_scenario("examples/small", settings), rules={"poa": switch}, out=tmp_path / "switched")
    assert keys(str(tmp_path / "switched"))


def test_what_is_nothing_of_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no result\.json"):
        cited([str(tmp_path)])
    with pytest.raises(InputError, match=r'found "pod-mach" \(did you mean `pod-match`'):
        cited(["pod-mach"])


JOURNAL = """W. E. Smith: Various optimizers. Naval Research
    Quarterly 3(1), 59-66, 1956. https://doi.org/10.1002/n_1 (the idea)"""
ENTRY = """@article{smith1956various,
  author = {W. E. Smith},
  title = {Various optimizers},
  journal = {Naval Research Quarterly},
  volume = {3},
  number = {1},
  pages = {59--66},
  year = {1956},
  doi = {10.1002/n_1},
}
"""


def test_kinds_of_sources() -> None:
    (found,) = references_in(JOURNAL)
    assert (found.bibtex(), found.note) == (ENTRY, "the idea")
    (found,) = references_in("M. Merschformann, H. Li: RAWSim-O: a framework. Logistics 11, 8, 2018.")
    assert "  author = {M. Merschformann and H. Li}," in found.bibtex()
    assert "  title = {{RAWSim-O:} a framework}," in found.bibtex()
    text = "A. Bee: On honey. Hive 1, 2, 2001.\n\nA. Bee: On honey. Hive 1, 2, 2001 (the idea).\n\n"
    found = with_own_keys(references_in(f"{text}A. Bee: On honey and wax. Hive 1, 3, 2001."))
    assert [reference.key for reference in found] == ["bee2001honey", "bee2001honeyb"]


@cases(
    "text kind fields",
    (
        "L. Xie, H. Li: Efficient methods. arXiv:1902.03092, 2019. https://arxiv.org/abs/1902.03092",
        "misc",
        {"eprint": "1902.03092", "year": "2019", "url": "https://arxiv.org/abs/1902.03092"},
    ),
    ("H. Ma, S. Koenig: Lifelong planning. AAAI 2019.", "inproceedings", {"booktitle": "AAAI", "year": "2019"}),
    ("J. R. Jackson: Tardiness. Report 43, Los Angeles, 1955.", "misc", {"howpublished": "Report 43, Los Angeles"}),
    ("Found in a drawer. doi: 10.1/a", "misc", {"note": "Found in a drawer. doi: 10.1/a", "doi": "10.1/a"}),
)
def test_other_kinds(text: str, kind: str, fields: dict[str, str]) -> None:
    """Preprints, conferences, reports; what is written otherwise is a note as a whole."""
    (found,) = references_in(text)
    assert (found.kind, {**found.fields, **fields}) == (kind, found.fields)


@given(st.text())
def test_any_text_gives_entries(text: str) -> None:
    for reference in references_in(text):
        entry = reference.bibtex()  # BibTeX counts braces after a backslash, too
        assert entry.count("{") == entry.count("}")
        assert re.fullmatch(r"@\w+\{\w+,", reference.bibtex().split("\n")[0])
