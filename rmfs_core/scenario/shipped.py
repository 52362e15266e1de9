"""The scenarios that are installed with the package."""

from __future__ import annotations

import importlib.util
from pathlib import Path

PACKAGE = "rmfs_scenarios"  # the top-level folder `scenarios`, under the name it is installed by
EXPERIMENTS = "experiments"  # the subfolder of the shipped experiments, which are no scenarios


def shipped_folder() -> Path:
    """Return the folder of the shipped scenarios."""
    package = importlib.util.find_spec(PACKAGE)
    if package is not None and package.submodule_search_locations:
        return Path(next(iter(package.submodule_search_locations)))
    return Path(__file__).parents[2] / "scenarios"  # run from a checkout that is on the path but not installed


def shipped_scenarios() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name (``paper-250``, ``examples/small``), sorted."""
    folder = shipped_folder()
    paths = (path.relative_to(folder) for path in folder.rglob("*.toml"))
    files = {path.with_suffix("").as_posix(): folder / path for path in paths if path.parts[0] != EXPERIMENTS}
    return dict(sorted(files.items()))


def summary(path: Path) -> str:
    """Return the first comment line of a scenario file, which says what it is for."""
    first = path.read_text(encoding="utf-8").partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""
