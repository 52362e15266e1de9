"""Reading a run's recorded decisions; the format is described in `rmfs_commands.states.recording`."""

from __future__ import annotations

import os.path
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.cli.options import DECIDING
from rmfs_commands.states.patches import patched
from rmfs_commands.states.recording import RECORDING_FILE, RECORDING_FORMAT, RECORDING_VERSION
from rmfs_commands.states.state import State
from rmfs_commands.states.state_json import check_format, state_from_dict
from rmfs_commands.trace.json_lines import read_json_lines
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, Scenario, scenario_from_dict
from rmfs_core.wording import listed, shown_short


@frozen(eq=False)
class Recorded:
    """A decision of a run.

    Parameters
    ----------
    number
        Its number among the recorded decisions, from 1.
    decides, rule
        Kind of the decision, and the rule's name.
    content
        The state that the rule saw, as JSON's objects.
    decision
        The decision, with names; None when the answer was nothing valid.
    report
        Status, objective, bound and whether the solve was stopped early, of a rule that reports them.
    place
        File and line, for messages.
    """

    number: int
    decides: Role
    rule: str
    content: Mapping[str, Any]
    decision: Mapping[str, Any] | None
    report: Mapping[str, Any] | None
    place: str

    @property
    def period(self) -> int:
        """Period t: how often orders were assigned until then, this decision included."""
        return int(self.content["ask"]["period"])

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return float(self.content["time_s"])

    def state(self) -> State:
        """Return the state that the rule saw, checked."""
        return state_from_dict(self.content, self.place)


@frozen(eq=False)
class Recording:
    """The recorded decisions of a run, read from the file each time they are gone through.

    Parameters
    ----------
    file
        The file.
    scenario
        The scenario of the run.
    """

    file: Path
    scenario: Scenario

    def __iter__(self) -> Iterator[Recorded]:
        """Go through the decisions, first to last.

        Raises
        ------
        InputError
            With the line, where the file is damaged or was cut off.
        """
        lines = read_json_lines(self.file)
        _, header = next(lines)
        content: Mapping[str, Any] = header["state"]
        for number, (place, line) in enumerate(lines, 1):
            if lacking := [key for key in ("change", "decides", "rule", "decision") if key not in line]:
                raise InputError(place, f"this is no recorded decision: it lacks {listed(lacking)}")
            for key in ("change", "decision", "report"):
                if not isinstance(line.get(key), Mapping) and (key == "change" or line.get(key) is not None):
                    raise InputError(f"{place}, {key}", f"expected a JSON object, found {shown_short(line[key])}")
            if not isinstance(line["rule"], str):
                raise InputError(f"{place}, rule", f"expected a rule's name, found {shown_short(line['rule'])}")
            try:
                content = patched(content, line["change"])
                decides = Role.labelled(line["decides"])
                recorded = Recorded(number, decides, line["rule"], content, line["decision"], line.get("report"), place)
                if decides not in DECIDING or recorded.period < 0 or recorded.time_s < 0:
                    raise InputError(place, f"found {decides.label} of period {recorded.period}; expected a decision")
            except (KeyError, TypeError, AttributeError, ValueError, OverflowError, RecursionError) as error:
                raise InputError(place, f"this is no recorded decision: {error}") from error
            yield recorded

    def choice_of(self, recorded: Recorded) -> RuleChoice:
        """Return the rule that decided, with its parameters, as the scenario has it."""
        rules, decides = self.scenario.rules, recorded.decides
        choice: RuleChoice | None = getattr(rules, decides.key)
        if choice is None and decides is Role.PPS and rules.poa_pps is not None:  # a session repairs what that leaves
            return RuleChoice(recorded.rule)
        if choice is None:
            raise InputError(recorded.place, f"the scenario of the run has no rule for {recorded.decides.label}")
        return choice


def read_recording(path: str | Path) -> Recording:
    """Return the recorded decisions of a run.

    Parameters
    ----------
    path
        The folder of a run, or the file.

    Raises
    ------
    InputError
        When there are none, or the file is not what it should be.
    """
    file = Path(path)
    if os.path.isdir(file):  # noqa: PTH112 (False for a name that is too long, too)
        folder, file = file, file / RECORDING_FILE
        if not file.exists():
            raise InputError(
                str(folder), "found no recorded decisions; run the scenario with `--record-decisions` to have them"
            )
    place, header = next(read_json_lines(file), (str(file), {}))
    check_format(header, RECORDING_FORMAT, (RECORDING_VERSION,), place)
    if not isinstance(header.get("state"), Mapping) or not isinstance(header.get("scenario"), Mapping):
        raise InputError(place, "the header lacks `scenario` or `state`")
    return Recording(file, scenario_from_dict(header["scenario"], name=f"{place}, scenario"))
