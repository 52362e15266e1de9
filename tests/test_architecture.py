"""How the code is divided: what each part may import, name and touch, and how large the kernel may get."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path

from attrs import frozen

ROOT = Path(__file__).resolve().parent.parent
KERNEL = ROOT / "rmfs_core"
PLUGINS = ROOT / "plugins"
RULES, COMMANDS, TRAFFIC = PLUGINS / "rmfs_rules", PLUGINS / "rmfs_commands", PLUGINS / "rmfs_traffic"
TOOLS = ROOT / "tools"
PUBLIC = ROOT / "docs" / "reference" / "api.md"

MOST_LINES, MOST_FILES, MOST_FOLDERS = 10_980, 71, 7
"""The kernel's budget, with little room, to be lowered when the kernel becomes smaller."""
MOST = {ROOT / "tests": 44_000, RULES: 13_990, RULES / "joint": 800, RULES / "pod_index": 950, RULES / "helpers": 1_500}
"""Budgets of tests and rules. A new test first looks for the table of its subject and for the test that it replaces."""

NAMES_A_PLUGIN = {
    "testing.py": "keeps `rmfs_core.testing` importable, under which tests of rules know those tools",
    "rule_helpers.py": "keeps `rmfs_core.rule_helpers` importable, from which rules take their loops and look-ups",
}
"""Modules of the kernel that name a plugin, with the reason."""

PRIVATE = re.compile(r"_[A-Za-z](\w*[^\W_])?")
DOCUMENTED = ("os._exit", "dispatcher._cache")
"""Underscored names that are public all the same; and where numba's compiled functions keep their cache, which
`rmfs_core.jit` replaces: pyproject.toml bounds numba's version for it."""

OF_NAMED_TUPLES = ("_asdict", "_fields", "_make", "_replace")
"""Likewise, of named tuples: without the underscore they could clash with fields."""


@frozen(eq=False)
class Module:
    """A module of the project."""

    name: str  # under which it is imported
    file: Path  # its file
    tree: ast.Module  # its code

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
    for folder, above in ((KERNEL, ROOT), (PLUGINS, PLUGINS)):
        yield from modules(folder, above).values()


def arrows(known: Mapping[str, Module]) -> dict[str, set[str]]:
    """Return which of some modules imports which; what a package imports when it is asked is in its stub."""
    found: dict[str, set[str]] = {name: set() for name in known}
    for name, module in known.items():
        stub = module.file.with_suffix(".pyi")
        stubs = [Module(name, module.file, ast.parse(stub.read_text(encoding="utf-8")))] if stub.exists() else []
        for origin, imported in (pair for one in (module, *stubs) for pair in one.imports()):
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


def grown(files: Sequence[Path], root: Path = ROOT) -> str:
    """Say which ten files have gained the most lines since the budget was last changed; without git, which are longest.

    Parameters
    ----------
    files
        The files that the budget is for, below the root.
    root
        Of the checkout, in which ``tests/test_architecture.py`` has the budget.
    """

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, encoding="utf-8", check=False)
        return done.stdout if done.returncode == 0 else ""

    set_in = ""
    with suppress(OSError):  # there is no git
        set_in = git("log", "-1", "--format=%h", "-G", "^MOST_LINES", "--", "tests/test_architecture.py").strip()
    gained = []
    for file in files:
        name, now = file.relative_to(root).as_posix(), len(file.read_text(encoding="utf-8").splitlines())
        before = len(git("show", f"{set_in}:{name}").splitlines()) if set_in else 0
        if now > before:
            gained.append((now - before, name))
    heading = f"lines gained since {set_in} set the budget:" if set_in else "the longest files:"
    return "\n".join([heading, *(f"{lines:6}  {name}" for lines, name in sorted(gained, reverse=True)[:10])])


def test_the_kernel_stays_small() -> None:
    """Lines, files and folders of Python keep to the budget; if not, the message says which files grew."""
    files = [module.file for module in kernel().values()]
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    assert lines <= MOST_LINES, grown(files)
    assert len(files) <= MOST_FILES, grown(files)
    assert len({file.parent for file in files} - {KERNEL}) <= MOST_FOLDERS


def test_tests_and_rules_stay_small() -> None:
    for folder, most in MOST.items():
        files = [*folder.rglob("*.py")]
        assert sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files) <= most, grown(files)


def test_what_grew_is_named(tmp_path: Path) -> None:
    """New and longer files are, with the lines gained; shorter ones are not. Without a repository the longest are."""
    budget, names = tmp_path / "tests" / "test_architecture.py", ("longer", "new", "same", "shorter")
    files = [tmp_path / f"{name}.py" for name in names]
    budget.parent.mkdir()
    budget.write_text("MOST_LINES = 9\n")
    for file, lines in zip(files, (2, 0, 3, 4), strict=True):
        file.write_text("x\n" * lines)
    files[1].unlink()
    settings = ("-c", "user.name=t", "-c", "user.email=t@example.org", "-c", "commit.gpgsign=false")
    for command in (["init", "-q"], ["add", "."], [*settings, "commit", "-qm", "Set the budget"]):
        subprocess.run(["git", *command], cwd=tmp_path, check=True)
    for file, lines in zip(files, (5, 7, 3, 1), strict=True):
        file.write_text("x\n" * lines)
    heading, *rows = grown(files, tmp_path).splitlines()
    assert re.fullmatch("lines gained since [0-9a-f]{7,} set the budget:", heading)
    assert rows == ["     7  new.py", "     3  longer.py"]
    shutil.rmtree(tmp_path / ".git")
    assert grown(files[:2], tmp_path).splitlines() == ["the longest files:", "     7  new.py", "     5  longer.py"]


def test_no_import_circle_between_files() -> None:
    """Whatever file one begins with, following its imports never leads back to it, under TYPE_CHECKING neither."""
    assert circles(arrows({**kernel(), **modules(PLUGINS, PLUGINS), **modules(TOOLS, TOOLS)})) == []


def test_arrows_between_packages_go_one_way() -> None:
    """Seen as wholes, the kernel's folders and the modules beside them import each other in one direction only."""

    def whole(name: str) -> str:
        return ".".join(name.split(".")[:2])

    graph: dict[str, set[str]] = {}
    for name, targets in arrows(kernel()).items():
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
    packages = {folder.name for folder in PLUGINS.iterdir()} - {"rmfs"}  # the word is in every other sentence
    named = re.compile(rf"\b({'|'.join(packages)})\b")
    for module in kernel().values():
        path = module.file.relative_to(KERNEL).as_posix()
        imported = {origin.partition(".")[0] for origin, _ in module.imports()} & {*packages, "rmfs"}
        texts = [node.value for node in ast.walk(module.tree) if isinstance(node, ast.Constant)]
        mentioned = {found for text in texts if isinstance(text, str) for found in named.findall(text)}
        assert bool(imported | mentioned) == (path in NAMES_A_PLUGIN), (path, imported | mentioned)


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
    for module in modules(folder, PLUGINS).values():
        for origin, name in module.imports():
            if origin.partition(".")[0] == "rmfs_core":
                assert not re.search(r"(^|\.)_", f"{origin}.{name or ''}"), f"{module.name}: {origin}.{name}"
                yield module.name, f"{origin}.{name}" if f"{origin}.{name}" in kernel() else origin


def test_plugins_import_the_kernels_public_modules() -> None:
    """The documentation lists them. A rule needs fewer than a command; what begins with an underscore is nobody's."""
    for_rules, for_commands = public_modules()
    assert {*for_rules, *for_commands} <= kernel().keys()
    assert not {*for_rules} & {*for_commands}
    by_rules = list(from_the_kernel(RULES))
    by_commands = [*from_the_kernel(COMMANDS), *from_the_kernel(TRAFFIC)]
    assert [found for found in by_rules if found[1] not in for_rules] == []
    assert [found for found in by_commands if found[1] not in (*for_rules, *for_commands)] == []
    assert {*for_commands} <= {imported for _, imported in by_commands}, "what no plugin imports need not be public"


def owned(tree: ast.Module) -> set[str]:
    """Return the private names that a module defines: at its top, in its classes or their slots, as attributes of self.

    A local variable or a text that looks like one makes nobody the owner.
    """
    names: set[str] = set()
    for scope in (tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))):
        for node in scope.body:
            match node:
                case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.AnnAssign(target=ast.Name(id=name)):
                    names.add(name)
                case ast.Assign(targets=[ast.Name(id="__slots__")], value=slots):
                    names |= {slot.value for slot in ast.walk(slots) if isinstance(slot, ast.Constant)}
                case ast.Assign(targets=targets):
                    names |= {target.id for target in targets if isinstance(target, ast.Name)}
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(value=ast.Name(id="self" | "cls"), attr=name, ctx=ast.Store()):
                names.add(name)
    return {name for name in names if PRIVATE.fullmatch(name)}


def reached_into(tree: ast.Module, own: Container[str] = ()) -> Iterator[str]:
    """Yield line and code where a private name is used or imported that is not one's own.

    ``self``, ``cls`` and ``super()`` are one's own; so is what has a name of ``own``. A name in a text counts where
    `getattr`, `setattr` or the like are handed it.
    """
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(value=ast.Name(id="self" | "cls") | ast.Call(func=ast.Name(id="super"))):
                continue
            case ast.Attribute(attr=name):
                names = [name]
            case ast.ImportFrom(names=aliases, level=0):
                names = [alias.name for alias in aliases]
            case ast.Call(
                func=ast.Name(id=called) | ast.Attribute(attr=called), args=[_, ast.Constant(value=name), *_]
            ):
                names = [str(name)] if called in ("getattr", "setattr", "hasattr", "delattr") else []
            case _:
                continue
        private = [name for name in names if PRIVATE.fullmatch(name) and name not in own]
        if private and ast.unparse(node) not in DOCUMENTED:
            yield f"line {node.lineno}: {ast.unparse(node)}"


def test_nobody_reaches_into_private_attributes() -> None:
    """``x._y`` stands in the folder that defines ``_y``; elsewhere only of ``self``, ``cls`` and ``super()``."""
    own: dict[Path, set[str]] = {}
    for module in everything():
        own.setdefault(module.file.parent, {*OF_NAMED_TUPLES}).update(owned(module.tree))
    found = [
        f"{module.file.relative_to(ROOT)}, {place}"
        for module in everything()
        for place in reached_into(module.tree, own[module.file.parent])
    ]
    assert found == []


def test_tests_and_fakes_reach_into_no_private_attribute() -> None:
    """They see what users see. What Python documents of named tuples is public in spite of its underscore."""
    found = [
        f"{file.relative_to(ROOT)}, {place}"
        for folder in ("tests", "tools", "docs")
        for file in sorted((ROOT / folder).rglob("*.py"))
        for place in reached_into(ast.parse(file.read_text(encoding="utf-8")), OF_NAMED_TUPLES)
    ]
    assert found == []


def test_private_names_are_found() -> None:
    """The search that the two tests above rest on finds each way to reach one, and who owns it."""
    tree = ast.parse(
        "from a import _b, c\n"
        "class D:\n"
        "    __slots__ = ('_e', 'f')\n"
        "    _g: int = 1\n"
        "    def _h(self):\n"
        "        self._i = _j = x._k\n"
        "        super()._l(cls._m, '_n')\n"
        "_o = x.y._p.q, getattr(x, '_r'), patch.setattr(x, '_s', 1), x.__t__, os._exit\n"
    )
    assert owned(tree) == {"_e", "_g", "_h", "_i", "_o"}
    assert sorted(reached_into(tree, {"_k"})) == [
        "line 1: from a import _b, c",
        "line 8: getattr(x, '_r')",
        "line 8: patch.setattr(x, '_s', 1)",
        "line 8: x.y._p",
    ]


def test_every_package_has_tests() -> None:
    """In the folder of its name below tests/, or in files beside that folder that name it, as those of most rules."""
    for part in (KERNEL, RULES, COMMANDS):
        beside = ROOT / "tests" / part.relative_to(ROOT)
        texts = [file.read_text(encoding="utf-8") for file in beside.glob("test_*.py")]
        for folder in sorted(file.parent for file in part.glob("*/__init__.py")):
            named = re.compile(rf"\b{part.name}\.{folder.name}\b")
            assert [*(beside / folder.name).rglob("test_*.py")] or any(map(named.search, texts)), folder


def test_tests_are_in_the_folder_of_their_package() -> None:
    """Who reads a test finds the code by the folder's name."""
    for below in (ROOT / "tests" / "rmfs_core", ROOT / "tests" / "plugins"):
        folders = {file.parent.relative_to(ROOT / "tests") for file in below.rglob("test_*.py")}
        assert [folder for folder in sorted(folders) if not (ROOT / folder).is_dir()] == []
