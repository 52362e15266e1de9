"""Experiments: scenarios, rule sets and seeds crossed into runs, computed once each, stored, and compared in pairs."""

from rmfs_core.experiments.compare import Comparison, Counted, Paired, summary
from rmfs_core.experiments.model import Axis, AxisPoint, Base, Experiment, Job, RuleSetChoice
from rmfs_core.experiments.reading import load_experiment, shipped_experiments
from rmfs_core.experiments.rows import Row
from rmfs_core.experiments.running import ExperimentResult, run_experiment
from rmfs_core.experiments.watching import Watcher

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
