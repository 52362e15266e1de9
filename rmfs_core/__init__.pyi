from .decisions import JointDecision, Leg, OrderAssignment, Path, PodTrip, SolveReport, TaskAssignment
from .errors import InputError, RmfsError, RuleError, RunError, StandstillError
from .hookspecs import hookimpl
from .results.result import Result
from .results.running import run
from .scenario.model import Scenario
from .scenario.reading import load_scenario

__all__ = [
    "InputError",
    "JointDecision",
    "Leg",
    "OrderAssignment",
    "Path",
    "PodTrip",
    "Result",
    "RmfsError",
    "RuleError",
    "RunError",
    "Scenario",
    "SolveReport",
    "StandstillError",
    "TaskAssignment",
    "hookimpl",
    "load_scenario",
    "run",
]
