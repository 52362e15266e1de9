"""Which code a run is made by: digests of the sources of every import package that takes part.

A version says too little: that of an editable install, or of a package that is found by its path, stays when its code
changes. What takes part is the kernel, what rules share, the packages of the selected rules and of those that they ask
in turn, of the way that robots drive, of processes and observers, and of the generators of layout and instance, and
what these import of their own distributions, of this project, or from outside of the folders of installed packages.
Other libraries are known by their versions.
"""

from __future__ import annotations

import hashlib
import os
import re
import site
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache, lru_cache
from importlib.machinery import ModuleSpec
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from rmfs_core import entrypoints
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario
from rmfs_core.world.instance_making import generator_of
from rmfs_core.world.layout_making import layout_maker

KERNEL = "rmfs_core"
ALWAYS = (KERNEL, "rmfs_rules.helpers")
"""Packages that take part in every run; rules know the second under other names."""

_COLLECTIONS = ("rmfs", "rmfs_commands", "rmfs_rules")
"""Packages of this project of which each module or package below counts for itself."""
_IMPORTS = re.compile(
    rb"""^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import\b[ \t(]*([\w., \t]*)|import[ \t]+([\w., \t]+))"""
    rb"""|\bimport_module\(\s*["']([\w.]+)""",
    re.MULTILINE,
)
_NO_SOURCES = frozenset({"__pycache__"})


def sources_of(rules: RuleSet, scenario: Scenario) -> dict[str, str]:
    """Return the digest of every import package that takes part in a run, by name.

    Files are read again only when they changed.

    Parameters
    ----------
    rules, scenario
        The rules of the run, and what else it is made by.
    """
    bound = [*rules.deciding, *rules.observers]
    classes = {cls for rule in bound for cls in (type(rule.instance), *rule.parts.classes)}
    roots = {_root(cls.__module__) for cls in classes}
    offered = {name: same[0] for name, same in entrypoints.offers(entrypoints.RULES).items()}
    selected = {rule.name for rule in bound}
    entries = [entry for name, entry in offered.items() if name in selected or _root(entry.module) in roots]
    entries += [same[0] for same in entrypoints.offers(entrypoints.OBSERVERS).values()]
    entries += [same[0] for name, same in entrypoints.offers(entrypoints.PROCESSES).items() if name != "state"]
    named = [(one.reserves, one.distribution) for one in (rule.traits for rule in bound) if one.reserves is not None]
    entries += [entrypoints.preferred(entrypoints.DRIVING, *one)[0] for one in named]
    entries += _makers(scenario)
    names = {*ALWAYS, *(entry.module for entry in entries)}
    names |= {kind.__module__ for cls in classes for kind in cls.__mro__}
    return _digests(names, entries, map(Path, rules.inline_files))


def sources_of_world(scenario: Scenario, packages: Iterable[str] = ()) -> dict[str, str]:
    """Return the digests of what makes a scenario's layout and instance, and of packages that take part besides."""
    entries = _makers(scenario)
    return _digests([*packages, *(entry.module for entry in entries)], entries)


def _makers(scenario: Scenario) -> list[EntryPoint]:
    """Return what makes the layout and the instance; nothing makes one that is read from files."""
    made = [] if scenario.instance.orders_file is not None else [generator_of(scenario.instance)[0]]
    return [layout_maker(scenario.layout)[0], *made]


def _digests(modules: Iterable[str], entries: Iterable[EntryPoint], files: Iterable[Path] = ()) -> dict[str, str]:
    """Return the digests of the packages of modules, and of what these and files import, by name."""
    own = {name for entry in entries for name in _packages_of(entrypoints.origin(entry)[0])}
    found: dict[str, str] = {}
    roots = {root for name in modules if (root := _root(name))}
    waiting = [*roots, *(root for file in files for root in _followed(_read(file)[1], own))]
    while waiting:
        package = waiting.pop()
        if package not in found:
            found[package], imported = _digest(package)
            waiting += _followed(imported, own) if package != KERNEL else []  # the kernel imports no plugin
    return dict(sorted(found.items()))


def changed_since(sources: Mapping[str, str]) -> list[str]:
    """Return the packages whose code is another one in this process than digests say.

    What counts is the code when this is asked first: a process goes on with the modules that it has imported.
    """
    return [package for package, digest in sources.items() if _when_first_asked(package) != digest]


@cache
def _when_first_asked(package: str) -> str:
    return _digest(package)[0]


def _digest(package: str) -> tuple[str, frozenset[str]]:
    """Return the digest of a package's files, and the names of all modules that they import."""
    spec, total, imported = _spec(package), hashlib.sha256(), set[str]()
    for name, file in sorted(_files(spec)) if spec is not None else ():
        digest, imports = _read(file)
        total.update(f"{name}\0{digest}\n".encode())
        imported |= imports
    return f"sha256:{total.hexdigest()}", frozenset(imported)


def _files(spec: ModuleSpec) -> Iterator[tuple[str, Path]]:
    """Yield every file of a package with its name inside, except for what is compiled from others, and hidden ones."""
    for location in spec.submodule_search_locations or ():
        for folder, below, files in os.walk(location):
            below[:] = [name for name in below if name not in _NO_SOURCES and not name.startswith(".")]
            for name in files:
                file = Path(folder, name)
                if not name.startswith(".") and file.suffix != ".pyc" and file.is_file():
                    yield file.relative_to(location).as_posix(), file
    if spec.submodule_search_locations is None and spec.origin is not None and Path(spec.origin).is_file():
        yield Path(spec.origin).name, Path(spec.origin)


def _read(file: Path) -> tuple[str, frozenset[str]]:
    about = file.stat()
    return _read_at(file, about.st_mtime_ns, about.st_size, about.st_ino)


@lru_cache(maxsize=10_000)
def _read_at(file: Path, *_changed: int) -> tuple[str, frozenset[str]]:
    """Return the digest of a file and what it imports, read once as long as it is not changed."""
    content = file.read_bytes()
    names = set[str]()
    for match in _IMPORTS.finditer(content) if file.suffix == ".py" else ():
        origin, taken, plain, called = (group.decode("ascii", "ignore") if group else "" for group in match.groups())
        names |= {origin, called, *_first_words(plain)} - {""}
        if origin in _COLLECTIONS:
            names |= {f"{origin}.{name}" for name in _first_words(taken)}
    return hashlib.sha256(content).hexdigest(), frozenset(names)


def _first_words(listed: str) -> set[str]:
    """Return the names of a list such as ``a, b as c``."""
    return {words[0] for part in listed.split(",") if (words := part.split())}


def _followed(imported: Iterable[str], own: Iterable[str]) -> Iterator[str]:
    """Yield the packages among what is imported whose code counts."""
    for name in imported:
        top, root = name.partition(".")[0], _root(name)
        if root and (top in (KERNEL, *_COLLECTIONS) or top in own or not _is_installed(root)):
            yield root


def _root(module: str) -> str | None:
    """Return the package of a module below all namespaces and collections, None when there is none."""
    parts = module.split(".")
    for count in range(1, len(parts) + 1):
        package = ".".join(parts[:count])
        spec = None if not parts[0] or parts[0] in sys.stdlib_module_names else _spec(package)
        if spec is None:
            return None
        if spec.origin is not None and package not in _COLLECTIONS:
            return package
    return None


def _spec(package: str) -> ModuleSpec | None:
    with suppress(ImportError, ValueError, AttributeError):
        return find_spec(package)
    return None


def _is_installed(package: str) -> bool:
    spec = _spec(package)
    if spec is None or spec.origin is None or not Path(spec.origin).is_file():
        return True
    return any(Path(spec.origin).is_relative_to(folder) for folder in _installed_in())


@cache
def _installed_in() -> tuple[str, ...]:
    """Return the folders of installed packages, whose code is known by its version."""
    paths = sysconfig.get_paths()
    named = {paths["purelib"], paths["platlib"], paths["stdlib"], paths["platstdlib"], site.getusersitepackages()}
    return tuple(sorted({*named, *site.getsitepackages(), *(p for p in sys.path if p.endswith("-packages"))}))


@cache
def _packages_of(name: str) -> frozenset[str]:
    """Return the import packages that a distribution has installed."""
    try:
        files = distribution(name).files or []
    except (PackageNotFoundError, ValueError):
        return frozenset()
    return frozenset(file.parts[0].removesuffix(".py") for file in files if file.suffix == ".py")
