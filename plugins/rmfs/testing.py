"""Tools for testing rules. (``rule_benchmark``, a fixture, is here too, and imported when it is asked for.)"""

from typing import TYPE_CHECKING, Any

from rmfs_commands.testing import *
from rmfs_commands.testing import __all__ as __all__

if TYPE_CHECKING:
    from rmfs_commands.bench.fixture import rule_benchmark as rule_benchmark


def __getattr__(name: str) -> Any:
    """Import the fixture, which needs pytest."""
    if name == "rule_benchmark":
        from rmfs_commands.bench.fixture import rule_benchmark

        return rule_benchmark
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
