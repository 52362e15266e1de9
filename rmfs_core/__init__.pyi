from .decisions import (
    BundleAssignment,
    BundleDecision,
    JointDecision,
    Leg,
    OrderAssignment,
    Path,
    PodMove,
    PodTrip,
    RobotMove,
    SolveReport,
    StoreBundle,
    TaskAssignment,
)
from .errors import InputError, RmfsError, RuleError, RunError, StandstillError
from .hookspecs import hookimpl
from .results.result import Result
from .results.running import run
from .scenario.model import Scenario
from .scenario.reading import load_scenario

__all__ = [
    "BundleAssignment",
    "BundleDecision",
    "InputError",
    "JointDecision",
    "Leg",
    "OrderAssignment",
    "Path",
    "PodMove",
    "PodTrip",
    "Result",
    "RmfsError",
    "RobotMove",
    "RuleError",
    "RunError",
    "Scenario",
    "SolveReport",
    "StandstillError",
    "StoreBundle",
    "TaskAssignment",
    "hookimpl",
    "load_scenario",
    "run",
]
