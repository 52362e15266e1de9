from math import prod

import pytest

from mip_periods import made_alike, random_period, scarce_period, splitting_period
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model


@pytest.fixture(scope="session")
def periods() -> list[Period]:
    return [random_period(seed) for seed in range(300)]


@pytest.fixture(scope="session")
def all_periods(periods: list[Period]) -> list[Period]:
    return [*periods, *map(made_alike, periods[:150])]


@pytest.fixture(scope="session")
def equal_stations(periods: list[Period]) -> list[Period]:
    return [made_alike(period) for period in periods if len(period.stations) > 1][:120]


@pytest.fixture(scope="session")
def small_periods() -> list[Period]:
    """Return random periods that are small enough to try everything, with all stations alike in every third."""
    periods = [random_period(seed) for seed in range(600)]
    periods += [splitting_period(seed, orders=4, stations=2 + seed % 2, skus=6) for seed in range(150)]
    periods[::3] = map(made_alike, periods[::3])
    return [
        period
        for period in periods
        if len(period.stations) > 1
        and prod(1 + len(period.stations) ** len(lines) for lines in period.lines) <= 3000
        and Reduced(period, Model.SPLIT_AMONG_STATIONS).candidates.any()
    ]


@pytest.fixture(scope="session")
def scarce_periods() -> list[Period]:
    return [scarce_period(seed) for seed in range(60)]
