"""Nothing that a user meets is undocumented: hooks, rules, commands, scenario keys, needs."""

import ast
import inspect
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import attrs
import click
import pytest
from click.testing import CliRunner

from rmfs_commands.cli.description import RuleDescription, installed_rules
from rmfs_commands.cli.main import rmfs
from rmfs_commands.cli.summary import GAPS, PROFILE
from rmfs_commands.details.catalogue import DETAILS, LATENESS, METRICS, OPENING, UNBUSY
from rmfs_commands.results.figures import TIMING
from rmfs_commands.testing import check_rule
from rmfs_core import hookspecs, run
from rmfs_core.hookspecs import DecisionHooks, FilterHooks, ObserverHooks, TimeHooks
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import marked_methods
from rmfs_core.rules.traits import NEEDS
from rmfs_core.scenario.model import RuleChoice, Scenario

DOCS = Path(__file__).resolve().parent.parent / "docs"
GENERATED: dict[str, Any] = runpy.run_path(str(DOCS / "generate.py"), run_name="generate")
"""Functions that make the parts of the reference that come from the code."""


def page(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


EVERYTHING = "".join(path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md")))


# Hooks


GROUPS = (DecisionHooks, FilterHooks, TimeHooks, ObserverHooks)
HOOKS = [name for group in GROUPS for name, hook in vars(group).items() if inspect.isfunction(hook)]
PREAMBLE, *_EXAMPLES = re.split(r"^@define\n", page("reference/hook_examples.py"), flags=re.MULTILINE)
DECIDED = {role.hook for role in Role if role is not Role.OBSERVER}
"""Hooks whose examples are templates of `rmfs new-rule`, which has tests of its own."""
EXAMPLES = {
    hook: f"@define\n{code}" for hook, code in zip((h for h in HOOKS if h not in DECIDED), _EXAMPLES, strict=True)
}
"""The example of each other hook, in the order of the hooks."""


def test_every_hook_has_its_row_and_its_arguments() -> None:
    shown = page("reference/hooks.md") + GENERATED["hooks"]() + GENERATED["decisions"]()
    for group in GROUPS:
        for name, hook in vars(group).items():
            if name.startswith("_"):
                continue
            assert re.search(rf"^\| .*`{name}`.* \|", shown, re.MULTILINE), name
            assert f".. automethod:: rmfs_core.hookspecs.{group.__name__}.{name}\n" in shown
            doc, returned = inspect.getdoc(hook) or "", hook.__annotations__["return"]
            described = re.split(r"\n\n(?:Parameters\n---|Returns\n---)", doc)[0]
            assert re.match(r"[A-Z].*\.$", described, re.DOTALL), name
            own = hook.__annotations__.keys() - {"return", "warehouse", "rng"}
            assert all(re.search(rf"^{argument}\n    \S", doc, re.MULTILINE) for argument in own), name
            assert (f"Returns\n-------\n{returned}\n    " in doc) == (returned != "None"), name
    for argument in ("warehouse", "rng"):
        assert f"``{argument}`` is " in (hookspecs.__doc__ or "")


@pytest.mark.slow
@pytest.mark.parametrize("hook", EXAMPLES)
def test_the_example_of_a_hook_runs(hook: str) -> None:
    names: dict[str, Any] = {"__name__": "example"}
    exec(PREAMBLE + EXAMPLES[hook], names)
    (rule,) = (thing for thing in names.values() if getattr(thing, "__module__", "") == "example")
    assert hook in marked_methods(rule)
    assert check_rule(rule()).times[hook].calls > 0


# Rules
def squeezed(text: str) -> str:
    return " ".join(text.split())


def gaps_in_rule(rule: RuleDescription, reference: str, shown: str) -> list[str]:
    """List what a rule lacks in its docstring, in its section of the reference, and in what `rmfs rules NAME` shows."""
    section = reference.partition(f"### `{rule.name}`\n")[2].partition("\n### ")[0]
    gaps = [] if ".. autoclass:: " in section else ["no section in the reference"]
    gaps += [] if rule.summary.endswith(".") else ["no summary"]
    numbers = re.findall(r"10\.\d{4,}/\S+|arXiv:\S+", rule.short_references())
    gaps += [] if numbers else ["no reference with its DOI or arXiv number"]
    shown = re.sub(r"\n *# ", " ", shown)  # lines that are filled are one text
    gaps += [f"{number} is not shown" for number in numbers if number not in shown]
    for parameter in rule.parameters:
        gaps += [] if parameter.doc else [f"parameter {parameter.name} is not described"]
        if section and f"| `{parameter.name}` |" not in section:
            gaps.append(f"parameter {parameter.name} is not in the section")
        if f"{parameter.name} = " not in shown or squeezed(
            parameter.doc.rstrip(".").replace("``", "`")
        ) not in squeezed(shown):
            gaps.append(f"parameter {parameter.name} is not shown")
    return gaps


SHIPPED = {rule.name: rule for rule in installed_rules() if rule.distribution == "rmfs"}


@pytest.fixture(scope="module")
def reference() -> str:
    return str(GENERATED["rules"]())


@pytest.fixture(scope="module")
def listed() -> str:
    return CliRunner().invoke(rmfs, ["rules"], catch_exceptions=False, env={"COLUMNS": "160"}).stdout


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_rule_is_documented(name: str, reference: str, listed: str) -> None:
    shown = CliRunner().invoke(rmfs, ["rules", name], catch_exceptions=False).stdout
    assert gaps_in_rule(SHIPPED[name], reference, shown) == []
    for number in SHIPPED[name].short_references().splitlines():
        assert number in listed


# Commands
def gaps_in_command(command: click.Command, called: str, pages: str) -> Iterator[str]:
    """List commands, and their options and arguments, that are not described in the help or named on a page."""
    context = click.Context(command, info_name=called)
    if not command.help:
        yield f"{called} has no help"
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            yield from gaps_in_command(below, f"{called} {name}", pages)
        return
    if not re.search(rf"{called}\b", pages):
        yield f"{called} is on no page"
    for parameter in command.params:
        if isinstance(parameter, click.Option) and not parameter.help:
            yield f"{called} {parameter.opts[0]} has no help"
        if isinstance(parameter, click.Argument):
            for name in parameter.make_metavar(context).strip("[].").split(" | "):
                if name not in (command.help or ""):
                    yield f"{called} {name} is not explained in the help"


def test_every_command_and_option_is_documented() -> None:
    assert list(gaps_in_command(rmfs, "rmfs", EVERYTHING)) == []


# Scenario keys
UNITS = {"_s": "s", "_per_s": "m/s", "_per_s2": "m/s^2", "_per_hour": "1/h"}


def gaps_in_keys(section: type, reference: str, prefix: str = "") -> Iterator[str]:
    """List keys without a meaning, times without their unit, and keys that are not in the reference with both."""
    attrs.resolve_types(section)
    for key in attrs.fields(section):
        if key.metadata.get("internal"):
            continue
        path, meaning, unit = prefix + key.name, key.metadata.get("doc"), key.metadata.get("unit") or ""
        if not meaning:
            yield f"{path} has no meaning"
            continue
        kinds = [kind for kind in (key.type, *get_args(key.type)) if isinstance(kind, type) and attrs.has(kind)]
        if kinds and RuleChoice not in kinds:
            yield from gaps_in_keys(kinds[0], reference, f"{path}.")
            continue
        ending = re.search(r"(_per_s2?|_per_hour|_s)$", key.name)
        if ending and unit != UNITS[ending[1]]:
            yield f"{path} has no unit"
        row = next((line for line in reference.splitlines() if line.startswith(f"| `{path}` |")), "")
        if not row.replace("\\|", "|").endswith(f"| {unit} | {meaning} |"):
            yield f"{path} is not in the reference with its unit and meaning"


def test_every_scenario_key_is_documented() -> None:
    assert list(gaps_in_keys(Scenario, GENERATED["scenario_keys"]())) == []


# Needs and the conformance suite


def test_every_need_is_documented() -> None:
    text = GENERATED["needs"]()
    assert [need for need in NEEDS if f'| `"{need}"` |' not in text] == []


def test_every_finding_is_documented() -> None:
    from rmfs_commands.testing import conformance, trial

    for kind in (trial.IMPOSSIBLE, trial.RAISED, trial.STARVED, trial.MUTATED, conformance.RANDOM, conformance.KEPT):
        assert f"| `{kind}` |" in page("how-to/test-a-rule.md")
        assert f'``"{kind}"``' in (conformance.Finding.__doc__ or "")


# Files
def test_every_column_is_documented() -> None:
    from rmfs_commands.experiments.report.tables import SUMMARY_COLUMNS
    from rmfs_commands.instances.csv_files import ORDER_COLUMNS, POD_COLUMNS

    text = page("reference/files.md")
    rows = "\n".join(line.split("|")[1] for line in text.splitlines() if line.startswith("| `"))
    for columns in (ORDER_COLUMNS, POD_COLUMNS, SUMMARY_COLUMNS):
        assert [column for column in columns if f"`{column}`" not in rows] == []


def test_every_column_that_a_run_writes_is_documented(tmp_path: Path) -> None:
    overrides = ["instance.orders=2", "instance.due.allowance_s=60", "rules.pp=free-flow"]
    run("examples/small", overrides=overrides, out=tmp_path)
    tables = sorted(tmp_path.glob("*.csv"))
    assert {"orders.csv", "hours.csv", "stations.csv", "robots.csv", "delays.csv"} <= {table.name for table in tables}
    for table in tables:
        section = page("reference/files.md").partition(f"\n### `{table.name}`\n")[2].partition("\n### ")[0]
        described = "".join(line.split("|")[1] for line in section.splitlines() if line.startswith("| `"))
        columns = table.read_text(encoding="utf-8").splitlines()[0].split(",")
        assert [column for column in columns if f"`{column}`" not in described] == [], table.name


# Words
def terms(glossary: str) -> set[str]:
    """Return the terms that a glossary defines, in small letters."""
    found = set()
    for part in re.findall(r"^:::\{glossary\}\n(.*?)^:::$", glossary, re.MULTILINE | re.DOTALL):
        for line in part.splitlines():
            if line and not line.startswith(" "):
                found |= {line.lower(), *line.lower().split(", ")}
    return found


def undefined(labels: list[str], defined: set[str]) -> list[str]:
    """List labels that are no term, nor terms with commas between them; the plural of a term is one."""
    found = defined | {f"{term}s" for term in defined}
    return [label for label in labels if not ({label.lower()} <= found or {*label.lower().split(", ")} <= found)]


SHOWN = (
    *("Simulated time", "Time used", "Ends in about", "Robots", "busy", "idle", "Station", "Load", "Pod", "In line"),
    *("Inbound", "Requests", "Picks"),
    *("Rule set", "Pairs", "Mean", "Difference", "Relative", "p (Holm)", "Runs", "Complete", "Partial", "Failed"),
    *("Stood still", "Stopped early", "x bound", "Times the bound", "Interval", "Seeds", "Verdict"),
    *("Free", "Not covered", "Queue free", "Inbound pods", "Order", "Waits", "Drive", "New visits", "Unused"),
    *("Visits + 2 unused", "Objective", "Bound", "Period"),
    *("Scenario", "Experiment", "Metric", "Event", "Trace", "Recorder", "Fault", "Hook", "Observer", "Inline rule"),
    *("Due in", "Priority", "Where the time went", "Effort"),
    *("Optimal", "Stopped", "Below", "Above", "In range", "Same", "Pile-on", "Visits per order", "ms /call", "s /run"),
    *("Calls", "Makespan", "Sum of costs", "Delay", "Stops", "Queries", "Collisions"),
)
"""Words of the live display, of comparisons, explanations, benchmarks and plans."""


def test_the_glossary_defines_what_a_run_prints() -> None:
    defined = terms(page("reference/glossary.md"))
    ours = (*DETAILS, *OPENING, *LATENESS, *UNBUSY, *GAPS)
    metrics = (*(m for group in METRICS.values() for m in group), *TIMING, *ours)
    labels = [metric.label.strip() for metric in metrics]
    profile = [re.split(r":| \(", label)[0] for label in PROFILE.values()]  # what follows are examples
    assert undefined([*labels, *profile, *SHOWN], defined) == []
    assert undefined(["Picks, tail", "Pick, p95", "Nose"], {"pick", "p95"}) == ["Picks, tail", "Nose"]
    assert "flow time" not in defined and terms(":::{glossary}\na, b\n  C, d.\n:::\n") == {"a", "b", "a, b"}


def test_every_metric_is_in_the_reference() -> None:
    for metric in (*(m for group in METRICS.values() for m in group), *TIMING, *DETAILS, *OPENING, *LATENESS):
        assert f"| `{metric.name}` | {metric.label.strip()} |" in GENERATED["metrics"]()


# Where things are
def names_in(file: Path) -> set[str]:
    """Return the names in a file's code; a comment or a docstring that has a word in it does not count."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.Name(id=name) | ast.Attribute(attr=name):
                found.add(name)
            case ast.keyword(arg="specname", value=ast.Constant(value=str(name))):  # of a hook
                found.add(name)
    return found


def wrong_places(table: str, root: Path) -> list[str]:
    wrong = []
    for line in table.splitlines():
        codes = re.findall(r"`([^`\s]+)`", line)
        files = [root / code for code in codes if code.endswith(".py")]
        wrong += [f"{file.relative_to(root)} is not there" for file in files if not file.is_file()]
        known = set().union(*(names_in(file) for file in files if file.is_file()))
        absent = [code for code in codes if code.isidentifier() and files and code not in known]
        wrong += [f"`{name}` is not in {files[0].relative_to(root)}" for name in absent]
    return wrong


def test_where_do_i_find_leads_to_what_is_there() -> None:
    text = page("explanation/where-do-i-find.md")
    assert wrong_places(text + page("explanation/add-a-capability.md"), DOCS.parent) == []
    assert len(re.findall(r"^\| .*\.py`", text, re.MULTILINE)) > 25
    moved = "| a | `rmfs_core/clock.py` | `to_ticks`, `to_moons`, `millisecond` |\n"  # the last in its docstring alone
    moved += "| b | `rmfs_core/moon.py` | `to_ticks` |"
    assert wrong_places(moved, DOCS.parent) == [
        "`to_moons` is not in rmfs_core/clock.py",
        "`millisecond` is not in rmfs_core/clock.py",
        "rmfs_core/moon.py is not there",
        "`to_ticks` is not in rmfs_core/moon.py",
    ]


OWN = re.compile(r"^\s*(?:from|import) (rmfs_\w+(?:\.\w+)*)", re.MULTILINE)
INTERNAL = {
    "docs/how-to/score-by-columns.md": {"rmfs_rules.helpers.pairs", "rmfs_rules.helpers.sending"},
    "docs/reference/hook_examples.py": {"rmfs_traffic", "rmfs_rules.sipp"},
}
"""Imports of pages besides the façade: rules of ours, and modules that only few need."""


def test_what_pages_and_templates_show_imports_the_facade() -> None:
    root = DOCS.parent
    files = [root / "README.md", *DOCS.rglob("*.md"), *DOCS.rglob("*.ipynb"), DOCS / "reference" / "hook_examples.py"]
    files += (root / "plugins" / "rmfs_commands" / "kit" / "templates").rglob("*.*")
    found = {}
    for file in files:
        if "_generated" not in file.parts and file.suffix in (".md", ".ipynb", ".py"):
            text = file.read_text(encoding="utf-8").replace('"', "\n")
            if named := {*OWN.findall(text)}:
                found[file.relative_to(root).as_posix()] = named
    assert found == INTERNAL
