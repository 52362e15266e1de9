"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems, simulated and compared fairly.

What users and authors of rules need, under one name: `run`, `load_result`, `run_experiment`, `hookimpl`, what rules
return, and the modules ``rmfs.warehouse``, ``rmfs.events``, ``rmfs.helpers``, ``rmfs.testing`` and ``rmfs.gym``.
``__init__.pyi`` names all. Each is imported when it is first used: ``import rmfs`` costs next to nothing.
"""

from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from rmfs.lazy import names_of

_MODULES = ("events", "gym", "helpers", "testing", "warehouse")
_get, _names = names_of(Path(__file__).with_suffix(".pyi"))
__all__ = ["__version__", *_MODULES, *_names]  # noqa: PLE0604 (all are texts)


def __getattr__(name: str) -> object:
    if name == "__version__":
        return version("rmfs")
    return import_module(f"rmfs.{name}") if name in _MODULES else _get(name)


def __dir__() -> list[str]:
    return __all__
