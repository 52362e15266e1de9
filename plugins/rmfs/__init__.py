"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems, simulated and compared fairly.

What users and authors of rules need, under one name: `run`, `load_result`, `run_experiment`, `hookimpl`, what rules
return, and the modules ``rmfs.warehouse``, ``rmfs.events``, ``rmfs.helpers``, ``rmfs.layouts``, ``rmfs.testing`` and
``rmfs.gym``. ``__init__.pyi`` names all. Each is imported when it is first used: ``import rmfs`` costs next to nothing.
"""

import importlib
import importlib.metadata

from rmfs.lazy import names_of

_MODULES = ("events", "gym", "helpers", "layouts", "testing", "warehouse")
_get, _names = names_of(__file__)
__all__ = ["__version__", *_MODULES, *_names]  # noqa: PLE0604 (all are texts)


def __getattr__(name: str) -> object:
    if name == "__version__":
        return importlib.metadata.version("rmfs")
    return importlib.import_module(f"rmfs.{name}") if name in _MODULES else _get(name)


def __dir__() -> list[str]:
    return __all__
