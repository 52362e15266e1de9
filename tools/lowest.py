"""Print the lowest versions of what rmfs needs when it runs, as constraints for pip.

Usage: python tools/lowest.py [PYPROJECT] > constraints.txt

They are the lower bounds of the dependencies in ``pyproject.toml``, and of the optional ones but for those that develop
rmfs: ``pip install --constraint constraints.txt ".[test]"`` installs these versions and whatever they need.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

PYPROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
DEVELOPING = ("test", "docs", "lint")
"""Optional dependencies that nobody needs to run rmfs."""


def constraints(pyproject: str) -> list[str]:
    """Return a constraint for each dependency, such as ``numpy==1.26``.

    Parameters
    ----------
    pyproject
        The text of a ``pyproject.toml``.

    Raises
    ------
    ValueError
        When a dependency has no lower bound.
    """
    project = tomllib.loads(pyproject)["project"]
    optional = project.get("optional-dependencies", {})
    needed = [*project["dependencies"], *(one for name in optional if name not in DEVELOPING for one in optional[name])]
    found = []
    for one in needed:
        bound = re.match(r"([\w.-]+)\s*>=\s*([\w.]+)", one)
        if bound is None:
            raise ValueError(f'"{one}" has no lower bound; expected one such as "numpy>=1.26"')
        found.append(f"{bound[1]}=={bound[2]}")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the constraints of a ``pyproject.toml``; return the exit code."""
    given = sys.argv[1:] if arguments is None else arguments
    print("\n".join(constraints(Path(given[0] if given else PYPROJECT).read_text(encoding="utf-8"))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
