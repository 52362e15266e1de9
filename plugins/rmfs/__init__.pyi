from rmfs_commands.bounds import Bound as Bound
from rmfs_commands.bounds import bounds_of as bounds_of
from rmfs_commands.cli.hall import Hall as Hall
from rmfs_commands.cli.hall import hall as hall
from rmfs_commands.cli.main import main as main
from rmfs_commands.details.loading import load_result as load_result
from rmfs_commands.experiments import Experiment as Experiment
from rmfs_commands.experiments import ExperimentResult as ExperimentResult
from rmfs_commands.experiments import load_experiment as load_experiment
from rmfs_commands.experiments import run_experiment as run_experiment
from rmfs_commands.replay import Page as Page
from rmfs_commands.replay import replay as replay
from rmfs_commands.states import Answer as Answer
from rmfs_commands.states import Decider as Decider
from rmfs_commands.states import Outcome as Outcome
from rmfs_commands.states import Recorded as Recorded
from rmfs_commands.states import Recording as Recording
from rmfs_commands.states import State as State
from rmfs_commands.states import decide as decide
from rmfs_commands.states import read_recording as read_recording
from rmfs_commands.states import read_state as read_state
from rmfs_commands.states import state_from_dict as state_from_dict
from rmfs_commands.states import state_schema as state_schema
from rmfs_commands.states import state_to_dict as state_to_dict
from rmfs_core import *  # noqa: F403
from rmfs_core.clock import to_seconds as to_seconds
from rmfs_core.clock import to_ticks as to_ticks
from rmfs_core.info import Question as Question
from rmfs_core.info import RunInfo as RunInfo
from rmfs_core.randomness import stream as stream
from rmfs_core.results.catalogue import Metric as Metric
from rmfs_core.roles import Role as Role
from rmfs_core.scenario import InstanceSection as InstanceSection
from rmfs_core.scenario import LayoutSection as LayoutSection
from rmfs_core.scenario import RuleChoice as RuleChoice

from . import events as events
from . import gym as gym
from . import helpers as helpers
from . import layouts as layouts
from . import testing as testing
from . import warehouse as warehouse
from . import world as world

__version__: str
