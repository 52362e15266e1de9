"""How the code is divided: what each part may import, name and touch, and how large the kernel may get."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest
from attrs import frozen

ROOT = Path(__file__).resolve().parent.parent
KERNEL = ROOT / "rmfs_core"
RULES = ROOT / "plugins" / "rules"
COMMANDS = ROOT / "plugins" / "commands"
PUBLIC = ROOT / "docs" / "reference" / "api.md"

MOST_LINES, MOST_FILES, MOST_FOLDERS = 9_600, 75, 8
"""The kernel's budget. A capability may raise it by at most 300 lines, with its reason in the changelog."""

NAMES_A_PLUGIN = {
    "testing.py": "keeps `rmfs_core.testing` importable, under which tests of rules know those tools",
    "rule_helpers.py": "keeps `rmfs_core.rule_helpers` importable, from which rules take their loops and look-ups",
}
"""Modules of the kernel that name a plugin, with the reason."""

PRIVATE = re.compile(r"_[A-Za-z](\w*[^\W_])?")
DOCUMENTED = ("os._exit",)
"""Underscored names that are public all the same."""


def folders(parent: Path) -> list[str]:
    """Return the import packages in a folder, by name."""
    return sorted(folder.name for folder in parent.iterdir() if (folder / "__init__.py").exists())


RULE_PACKAGES, COMMAND_PACKAGES = folders(RULES), folders(COMMANDS)
LIBRARY = "rmfs_rule_helpers"
"""What rules share; no rule itself."""


@frozen(eq=False)
class Module:
    """A module of the project.

    Parameters
    ----------
    name
        Under which it is imported.
    file
        Its file.
    tree
        Its code.
    """

    name: str
    file: Path
    tree: ast.Module

    @property
    def package(self) -> str:
        """Name of the package that relative imports start from."""
        return self.name if self.file.name == "__init__.py" else self.name.rpartition(".")[0]

    def imports(self) -> Iterator[tuple[str, str | None]]:
        """Yield module and name of every import, wherever it stands: in a function or under TYPE_CHECKING, too."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                yield from ((alias.name, None) for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                above = self.package.split(".")[: len(self.package.split(".")) - node.level + 1] if node.level else []
                origin = ".".join([*above, *([node.module] if node.module else [])])
                yield from ((origin, alias.name) for alias in node.names)


@cache
def modules(folder: Path, above: Path) -> Mapping[str, Module]:
    """Return the modules below a folder by the names that an import finds them under from ``above``."""
    found = {}
    for file in sorted(folder.rglob("*.py")):
        if "templates" not in file.parts:
            parts = file.relative_to(above).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = Module(name, file, ast.parse(file.read_text(encoding="utf-8")))
    return found


def kernel() -> Mapping[str, Module]:
    """Return the kernel's modules."""
    return modules(KERNEL, ROOT)


def everything() -> Iterator[Module]:
    """Yield every module of kernel, rules and commands."""
    for folder, above in ((KERNEL, ROOT), (RULES, RULES), (COMMANDS, COMMANDS)):
        yield from modules(folder, above).values()


def arrows() -> dict[str, set[str]]:
    """Return which module of the kernel imports which. Those of a package's __init__ are its modules' own business."""
    known = kernel()
    found: dict[str, set[str]] = {name: set() for name in known}
    for name, module in known.items():
        for origin, imported in module.imports():
            target = f"{origin}.{imported}" if f"{origin}.{imported}" in known else origin
            if target in known and target != name:
                found[name].add(target)
    return found


def circles(graph: Mapping[str, set[str]]) -> list[str]:
    """Return the circles of a graph, each once: what is left when all that leads nowhere else is taken away."""
    left = {node: set(targets) for node, targets in graph.items()}
    while True:
        ends = [node for node, targets in left.items() if not targets & left.keys()]
        if not ends:
            break
        for node in ends:
            del left[node]
    found = []
    for start in left:
        path = [start]
        while (following := min(left[path[-1]] & left.keys())) not in path:
            path.append(following)
        circle = path[path.index(following) :]
        first = circle.index(min(circle))
        found.append(" -> ".join([*circle[first:], *circle[:first], circle[first]]))
    return sorted(set(found))


def test_the_kernel_stays_small() -> None:
    """Lines, files and folders of Python keep to the budget."""
    files = [module.file for module in kernel().values()]
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    assert lines <= MOST_LINES
    assert len(files) <= MOST_FILES
    assert len({file.parent for file in files} - {KERNEL}) <= MOST_FOLDERS


def test_no_import_circle_between_files() -> None:
    """Whatever file one begins with, following its imports never leads back to it."""
    assert circles(arrows()) == []


def test_arrows_between_packages_go_one_way() -> None:
    """Seen as wholes, the kernel's folders and the modules beside them import each other in one direction only."""

    def whole(name: str) -> str:
        return ".".join(name.split(".")[:2])

    graph: dict[str, set[str]] = {}
    for name, targets in arrows().items():
        if name != "rmfs_core":
            graph.setdefault(whole(name), set()).update(
                whole(target) for target in targets if whole(target) not in ("rmfs_core", whole(name))
            )
    assert circles(graph) == []


def test_circles_are_found() -> None:
    """The search that the two tests above rest on finds a circle, and nothing in a graph without one."""
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == ["b -> c -> b"]
    assert circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_the_kernel_names_no_plugin() -> None:
    """No module of rmfs_core imports a package of plugins/, nor has its name in a text: all go through entry points."""
    packages = (*RULE_PACKAGES, *COMMAND_PACKAGES)
    named = re.compile(rf"\b({'|'.join(packages)})\b")
    for module in kernel().values():
        path = module.file.relative_to(KERNEL).as_posix()
        imported = {origin.partition(".")[0] for origin, _ in module.imports()} & set(packages)
        texts = [node.value for node in ast.walk(module.tree) if isinstance(node, ast.Constant)]
        mentioned = {found for text in texts if isinstance(text, str) for found in named.findall(text)}
        assert bool(imported | mentioned) == (path in NAMES_A_PLUGIN), (path, imported | mentioned)


@pytest.mark.parametrize("package", RULE_PACKAGES)
def test_a_rule_imports_the_kernel_alone(package: str) -> None:
    """A rule's package knows neither another rule's nor a command's; only the library that rules share."""
    foreign = {*RULE_PACKAGES, *COMMAND_PACKAGES} - {package, LIBRARY}
    for module in modules(RULES / package, RULES).values():
        assert not {origin.partition(".")[0] for origin, _ in module.imports()} & foreign, module.name


@pytest.mark.parametrize("package", COMMAND_PACKAGES)
def test_a_command_imports_no_rule(package: str) -> None:
    """Commands reach rules by name, as a scenario does."""
    for module in modules(COMMANDS / package, COMMANDS).values():
        assert not {origin.partition(".")[0] for origin, _ in module.imports()} & set(RULE_PACKAGES), module.name


def public_modules() -> tuple[list[str], list[str]]:
    """Return the modules that the documentation names as public: for rules and observers, and for commands besides."""
    text = PUBLIC.read_text(encoding="utf-8")
    rules, commands = text.partition("## Modules for rules and observers")[2].split("## Modules for commands")
    for_rules, for_commands = (
        re.findall(r"^\| `(rmfs_core[\w.]*)` \|", part, re.MULTILINE) for part in (rules, commands)
    )
    return for_rules, for_commands


def from_the_kernel(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield who imports which module of the kernel, among the modules of a folder of plugins."""
    for module in modules(folder, folder).values():
        for origin, name in module.imports():
            if origin.partition(".")[0] == "rmfs_core":
                assert not re.search(r"(^|\.)_", f"{origin}.{name or ''}"), f"{module.name}: {origin}.{name}"
                yield module.name, f"{origin}.{name}" if f"{origin}.{name}" in kernel() else origin


def test_plugins_import_the_kernels_public_modules() -> None:
    """The documentation lists them. A rule needs fewer than a command; what begins with an underscore is nobody's."""
    for_rules, for_commands = public_modules()
    assert {*for_rules, *for_commands} <= kernel().keys()
    assert not {*for_rules} & {*for_commands}
    by_rules, by_commands = list(from_the_kernel(RULES)), list(from_the_kernel(COMMANDS))
    assert [found for found in by_rules if found[1] not in for_rules] == []
    assert [found for found in by_commands if found[1] not in (*for_rules, *for_commands)] == []
    assert {*for_commands} <= {imported for _, imported in by_commands}, "what no command imports need not be public"


@cache
def owned(folder: Path) -> set[str]:
    """Return the private names that a folder's modules define: functions, attributes of self, class and slot names."""
    names: set[str] = set()
    for file in folder.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            match node:
                case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.Name(id=name, ctx=ast.Store()):
                    names.add(name)
                case ast.Attribute(value=ast.Name(id="self" | "cls"), attr=name, ctx=ast.Store()):
                    names.add(name)
                case ast.Constant(value=str(name)):  # of __slots__
                    names.add(name)
    return {name for name in names if PRIVATE.fullmatch(name)}


def test_nobody_reaches_into_private_attributes() -> None:
    """``x._y`` stands in the folder that defines ``_y``; elsewhere only of ``self``, ``cls`` and ``super()``."""
    found = []
    for module in everything():
        own = owned(module.file.parent)
        for node in ast.walk(module.tree):
            if not isinstance(node, ast.Attribute) or not PRIVATE.fullmatch(node.attr) or node.attr in own:
                continue
            if ast.unparse(node) in DOCUMENTED:
                continue
            match node.value:
                case ast.Name(id="self" | "cls") | ast.Call(func=ast.Name(id="super")):
                    continue
            found.append(f"{module.file.relative_to(ROOT)}, line {node.lineno}: {ast.unparse(node)}")
    assert found == []


def test_import_linter_knows_every_package() -> None:
    """Its contracts in pyproject.toml name all rules and all commands, so that none is left out."""
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    contracts = {contract["id"]: contract for contract in linter["contracts"]}
    assert sorted(linter["root_packages"]) == sorted(["rmfs_core", *RULE_PACKAGES, *COMMAND_PACKAGES])
    assert sorted(contracts["plugins"]["forbidden_modules"]) == sorted([*RULE_PACKAGES, *COMMAND_PACKAGES])
    assert contracts["rules"]["modules"] == [package for package in RULE_PACKAGES if package != LIBRARY]
    for one, other in (("rules-and-commands", "commands-and-rules"), ("commands-and-rules", "rules-and-commands")):
        assert contracts[one]["source_modules"] == contracts[other]["forbidden_modules"]
    assert contracts["commands-and-rules"]["source_modules"] == RULE_PACKAGES
    assert contracts["rules-and-commands"]["source_modules"] == COMMAND_PACKAGES
    layered = " ".join(contracts["commands"]["layers"]).replace("|", " ").split()
    assert sorted(layered) == COMMAND_PACKAGES
