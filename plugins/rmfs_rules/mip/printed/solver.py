"""python-mip with fixed seed and quiet solvers."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from threading import local
from typing import Literal

import mip
from attrs import field, frozen

from rmfs_rules.mip.period.effort import Effort

Name = Literal["highs", "cbc", "gurobi"]
SEED = 1
_NAMES = {"highs": mip.HIGHS, "cbc": mip.CBC, "gurobi": mip.GUROBI}
_ENDINGS = {"highs": ("mip.highs", "highslib", "Highs_destroy"), "cbc": ("mip.cbc", "cbclib", "Cbc_deleteModel")}
_of_this_thread = local()


@frozen
class Limits:
    """Which solver, and when it stops.

    Parameters
    ----------
    solver
        ``"highs"``, ``"cbc"`` or ``"gurobi"``.
    threads
        Threads it uses; more than one may make results differ between machines.
    max_seconds
        Wall-clock limit of one period's solve, None for none.
    gap
        Relative gap at which it stops.
    effort
        Limit of the period's work, by solver and searches together.
    """

    solver: Name = "highs"
    threads: int = 1
    max_seconds: float | None = None
    gap: float = 0.0
    effort: Effort = field(factory=Effort)


@frozen
class Outcome:
    """Result of a solver.

    Parameters
    ----------
    values
        Value of each variable; None when no solution was found.
    objective, bound
        Objective value and proven bound.
    optimal
        Whether the solver proved optimality (up to `Limits.gap` and the absolute gap asked for).
    """

    values: Sequence[float] | None
    objective: float
    bound: float
    optimal: bool


def check_installed(solver: Name) -> None:
    """Raise `ValueError` when a solver is not installed."""
    if solver == "cbc" and find_spec("cbcbox") is None:
        raise ValueError('solver = "cbc" needs the package cbcbox, which comes with python-mip; "highs" is here')
    if solver == "gurobi":
        from mip import gurobi

        if not gurobi.has_gurobi:
            raise ValueError('solver = "gurobi" needs an installed Gurobi (GUROBI_HOME); "highs" and "cbc" are here')


def new_model(limits: Limits) -> mip.Model:
    """Return an empty model to be minimised.

    Raises
    ------
    ValueError
        When python-mip does not find the solver.
    """
    try:
        _load_ending(limits.solver)
        model = mip.Model(sense=mip.MINIMIZE, solver_name=_NAMES[limits.solver])
    except FileNotFoundError as error:
        raise ValueError(f'python-mip does not find the solver "{limits.solver}": {error}') from error
    model.verbose = 0
    model.threads = limits.threads
    model.seed = SEED
    return model


def optimise(
    model: mip.Model,
    limits: Limits,
    *,
    absolute_gap: float = 1e-6,
    seconds: float | None = None,
    nodes: int | None = None,
) -> Outcome:
    """Solve a model.

    Parameters
    ----------
    model
        The model.
    limits
        When to stop.
    absolute_gap
        Distance between objective and bound that counts as proven; just below 1 where the objective is a whole number.
    seconds
        Seconds left of `Limits.max_seconds`.
    nodes
        Most nodes of branch and bound; None for any number.
    """
    model.max_mip_gap = limits.gap
    model.max_mip_gap_abs = absolute_gap
    _settle_threads(limits)
    most: dict[str, float] = {} if nodes is None else {"max_nodes": max(nodes, 1)}
    if seconds is not None:
        most["max_seconds"] = max(seconds, 0.001)
    status = model.optimize(**most)
    found = status in (mip.OptimizationStatus.OPTIMAL, mip.OptimizationStatus.FEASIBLE) and model.num_solutions > 0
    bound = model.objective_bound
    values = [variable.x for variable in model.vars] if found else None
    objective = model.objective_value if found else float("inf")
    optimal = status == mip.OptimizationStatus.OPTIMAL
    if status in (mip.OptimizationStatus.INFEASIBLE, mip.OptimizationStatus.INT_INFEASIBLE):
        bound = float("inf")
    return Outcome(values, objective, float("-inf") if bound is None else bound, optimal)


def _settle_threads(limits: Limits) -> None:
    """HiGHS keeps a pool of threads for each thread that calls it, and refuses a run that asks for another number."""
    if limits.solver == "highs":
        if getattr(_of_this_thread, "highs", limits.threads) != limits.threads:
            import highspy

            highspy.Highs.resetGlobalScheduler(True)
        _of_this_thread.highs = limits.threads


def _load_ending(solver: Name) -> None:
    """Look up what ends a model now, not when an old one ends.

    That may be at any time: models are in reference cycles, and the garbage collector ends them. It may run while cffi
    parses the type of another call. cffi has a lock then, and needs it to look up a function for the first time: the
    same thread would wait for itself without end. A function that was looked up is called without the lock.
    """
    module, library, function = _ENDINGS.get(solver, ("mip", "", ""))  # Gurobi's functions are looked up on import
    getattr(getattr(import_module(module), library, None), function, None)
