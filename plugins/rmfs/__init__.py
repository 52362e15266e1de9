"""rmfs: interchangeable decision rules for robotic mobile fulfillment systems, simulated and compared fairly.

What users and authors of rules need, under one name: `run`, `load_result`, `run_experiment`, `hookimpl`, what rules
return, and the modules ``rmfs.warehouse``, ``rmfs.events``, ``rmfs.helpers``, ``rmfs.world``, ``rmfs.layouts``,
``rmfs.testing`` and ``rmfs.gym``. ``__init__.pyi`` names all. Each is imported when it is first used: ``import rmfs``
costs next to nothing.
"""

import importlib
import importlib.metadata

from rmfs.lazy import Names

_MODULES = ("events", "gym", "helpers", "layouts", "testing", "warehouse", "world")
_names = Names(__file__)
__all__ = ["__version__", *_MODULES, *_names]  # noqa: PLE0604 (all are texts)


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return importlib.import_module(f"rmfs.{name}")
    found = importlib.metadata.version("rmfs") if name == "__version__" else _names.get(name)
    globals()[name] = found  # the next time it is there
    return found


def __dir__() -> list[str]:
    return __all__
