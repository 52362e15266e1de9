from .compare import Comparison, Counted, Paired, summary
from .experiment import Axis, AxisPoint, Base, Experiment, Job, RuleSetChoice
from .experiment_file import load_experiment, shipped_experiments
from .rows import Row
from .running import ExperimentResult, run_experiment
from .watching import Watcher

__all__ = [
    "Axis",
    "AxisPoint",
    "Base",
    "Comparison",
    "Counted",
    "Experiment",
    "ExperimentResult",
    "Job",
    "Paired",
    "Row",
    "RuleSetChoice",
    "Watcher",
    "load_experiment",
    "run_experiment",
    "shipped_experiments",
    "summary",
]
