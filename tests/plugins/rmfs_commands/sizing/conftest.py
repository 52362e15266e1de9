"""A warehouse that is simulated at once, and workers in this process."""

import tomllib

import pytest

from rmfs_commands.experiments import Job
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_core import Scenario
from rmfs_core.scenario import scenario_from_dict

POISSON = """
[instance]
orders = 16
skus = 8
pods = 6
skus_per_pod = 3
[instance.arrivals]
process = "poisson"
orders_per_hour = 150
[layout]
block_rows = 5
block_columns = 2
stations_east = 2
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "demand"
pp = "free-flow"
"""


class Here:
    """Workers that are this process: nothing has to be started."""

    count = 1
    closed = False

    def __init__(self) -> None:
        self.jobs: list[Job] = []

    def run(self, job: Job) -> Outcome:
        self.jobs.append(job)
        return simulate(job)

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def here() -> Here:
    return Here()


@pytest.fixture
def poisson() -> Scenario:
    return scenario_from_dict(tomllib.loads(POISSON))


@pytest.fixture
def poisson_text() -> str:
    return POISSON
