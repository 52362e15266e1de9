"""Tools for testing rules."""

from typing import TYPE_CHECKING, Any

from rmfs_commands.testing import *
from rmfs_commands.testing import __all__ as _all

if TYPE_CHECKING:
    from rmfs_commands.bench.fixture import rule_benchmark as rule_benchmark

__all__ = [*_all, "rule_benchmark"]  # noqa: PLE0604 (names of another module)


def __getattr__(name: str) -> Any:
    """Import the fixture when it is asked for: it needs pytest."""
    if name == "rule_benchmark":
        from rmfs_commands.bench.fixture import rule_benchmark

        return rule_benchmark
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
