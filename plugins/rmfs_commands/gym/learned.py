"""Rule ``learned``: a small network scores each candidate by its row of features."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from attrs import define, field, frozen
from numpy.typing import NDArray

from rmfs_commands.gym.choices import FEATURES, Choice, Table
from rmfs_commands.gym.policy import PolicyRule
from rmfs_commands.results.files import write_text
from rmfs_core import InputError
from rmfs_core.roles import Role
from rmfs_core.wording import listed, shown_short

Floats = NDArray[np.float64]

HIDDEN = 4
"""Units of the hidden layer."""


@frozen(eq=False)
class RowNetwork:
    """A network that scores rows one by one, each by itself: it fits any number of rows.

    The score of a row x is x @ direct + tanh(x @ inner + shift) @ outer.

    Parameters
    ----------
    direct, inner, shift, outer
        Its weights, shapes (features,), (features, units), (units,) and (units,).
    """

    direct: Floats
    inner: Floats
    shift: Floats
    outer: Floats

    @staticmethod
    def size(features: int, units: int = HIDDEN) -> int:
        """Return how many weights a network has."""
        return features + (features + 2) * units

    @classmethod
    def of(cls, weights: Any, features: int) -> RowNetwork:
        """Return the network with so many weights, one after another, as learners change them.

        Raises
        ------
        ValueError
            Where they are not as many as some number of units needs, or not finite.
        """
        flat = np.array(weights, np.float64)
        units, rest = divmod(flat.size - features, features + 2)
        if flat.ndim != 1 or rest or units < 0 or not np.isfinite(flat).all():
            expected = f"{features} finite numbers, and {features + 2} more for each hidden unit"
            raise ValueError(f"expected {expected}, found {flat.size}")
        direct, inner, shift, outer = np.split(flat, np.cumsum([features, features * units, units]))
        return cls(direct, inner.reshape(features, units), shift, outer)

    def best(self, rows: NDArray[np.float32], mask: NDArray[Any]) -> int:
        """Return the slot with the highest score of those that a mask allows; ties go to the lowest.

        Scores that differ after the ninth decimal are ties: by that much the arithmetic of processors may differ.
        """
        allowed = np.flatnonzero(mask)
        x = rows[allowed].astype(np.float64)
        scores = x @ self.direct + np.tanh(x @ self.inner + self.shift) @ self.outer
        return int(allowed[scores.round(9).argmax()])


def read_networks(file: Path | None = None, *, may_wait: bool = False) -> Mapping[Role, RowNetwork]:
    """Return the networks of a file by what they decide; those that are shipped where none is given.

    The file is JSON: ``{"PPS": {"features": [names], "weights": [numbers]}}``.

    Raises
    ------
    ValueError
        Where it is no such file, or of other features.
    """
    place, expected = file or "learned.json", "expected a file of `rmfs.gym.write_networks`"
    try:
        text = _shipped() if file is None else file.read_text(encoding="utf-8")
        given = {Role.labelled(label): told for label, told in json.loads(text).items()}
        networks = {role: RowNetwork.of(told["weights"], len(told["features"])) for role, told in given.items()}
        for role, told in given.items():
            _check_features(role, told["features"], may_wait)
    except (json.JSONDecodeError, UnicodeDecodeError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{place} holds no weights of networks; {expected}") from error
    except (OSError, ValueError) as error:
        raise ValueError(f"{place} holds no networks for this version: {error}") from error
    return MappingProxyType(networks)


def _check_features(role: Role, learned: object, may_wait: bool) -> None:
    if learned != (names := _names(role, may_wait)):
        raise ValueError(f"the features of {role.label} are {shown_short(learned)}; expected {', '.join(names)}")


def _names(role: Role, may_wait: bool) -> list[str]:
    return [feature.name for feature in Table(may_wait=may_wait).columns(role)]


def write_networks(file: str | Path, weights: Mapping[str, Sequence[float]], *, may_wait: bool = False) -> None:
    """Write networks as the rule `learned` reads them.

    Parameters
    ----------
    file
        The file, JSON.
    weights
        Weights of each network, by what it decides: ``{"PPS": [...]}``.
    may_wait
        Whether they were learned in an environment in which the policy may wait.

    Raises
    ------
    InputError
        When a label or weights are none that the rule reads, or the file cannot be written.
    """
    told, roles = dict[str, Any](), {role.label: role for role in FEATURES}
    for label, numbers in weights.items():
        if label not in roles:
            raise InputError("weights", f"found {shown_short(label)}; expected {listed(roles, 'or')}")
        names = _names(roles[label], may_wait)
        try:
            RowNetwork.of(numbers, len(names))
        except (TypeError, ValueError) as error:
            raise InputError(f"weights of {label}", str(error)) from error
        told[label] = {"features": names, "weights": [round(float(weight), 4) for weight in numbers]}
    write_text(file, json.dumps(told) + "\n")


@cache
def _shipped() -> str:
    return files("rmfs_commands.gym").joinpath("learned.json").read_text(encoding="utf-8")


@define
class Learned(PolicyRule):
    """Choose what a small learned network scores highest, of the rows of features of all candidates.

    One network of a few dozen weights scores each candidate by its own row of features (`rmfs.gym.FEATURES`), so it can
    be used in a warehouse of any size:

        x @ direct + tanh(x @ inner + shift) @ outer

    The shipped weights were learned on ``examples/small`` from minus the pod-station visits, by an evolution strategy
    (CMA-ES), for PPS and for whole orders with their pods (POA+PPS). docs/how-to/train-a-policy.md makes them again,
    judge-a-policy.md compares them.

    References
    ----------
    N. Hansen, A. Ostermeier: Completely derandomized self-adaptation in evolution strategies. Evolutionary Computation
    9, 159-195, 2001. https://doi.org/10.1162/106365601750190398
    """

    decides: ClassVar[tuple[Role, ...]] = (Role.PPS, Role.POA_PPS)
    assign_orders = choose_storage_location = assign_tasks = None  # type: ignore[assignment]  # decided by other rules

    weights: Path | None = field(
        default=None,
        metadata={
            "doc": "File of the networks' weights, as `rmfs.gym.write_networks` writes it; left out: the shipped ones"
        },
    )
    _networks: Mapping[Role, RowNetwork] = field(init=False, repr=False, eq=False)

    def __attrs_post_init__(self) -> None:
        self._networks = read_networks(self.weights, may_wait=self.may_wait)

    def choose(self, choice: Choice) -> int:
        """Return the slot with the highest score."""
        if choice.decides not in self._networks:
            raise ValueError(
                f"its file has no network for {choice.decides.label}; expected one that was trained for it"
            )
        return self._networks[choice.decides].best(choice.observation, choice.mask)
