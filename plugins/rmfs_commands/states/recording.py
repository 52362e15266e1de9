"""Recording a run's decisions, ``decisions.jsonl.gz``: one JSON object a line, compressed with gzip, UTF-8.

First line, the header::

    format, version   "rmfs-decisions", 1
    scenario          the resolved scenario (as in result.json)
    state             the state before the first event, as `rmfs_commands.states.state` has it, without ``ask``

Then one line a decision of POA, PPS, POA and PPS together, PR, TA, ROA, RPS, ROA and RPS together, activation, idle
robots, repositioning, packing stations and tasks of packers, in the order in which they were made::

    decides, rule     what was decided, and the name of the rule
    change            what the state that the rule saw differs in from the one of the line before: a JSON merge patch
                      (RFC 7396). Its ``ask`` says what was asked
    decision          ``assignments`` (order, station, skus), ``trips`` (pod, station), ``tasks`` (robot, pod),
                      ``cell``, ``bundles`` (bundle, station), ``stores`` (bundle, pod), ``active`` (stations),
                      ``rests`` (robot, cell, charge), ``moves`` (pod, cell), ``packing`` (order, station) or
                      ``task`` (position); null when the rule answered nothing valid, which ended the run
    report            of a rule that reports on its solve: status, objective, bound, stopped_early

`rmfs_commands.states.read_recording` reads it. The random generator of a rule is in the state (``random``) once it has
drawn numbers; before that ``seed`` is enough.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from rmfs_commands.cli.options import DECIDING
from rmfs_commands.results.files import json_ready
from rmfs_commands.states.answers import answer_to_dict
from rmfs_commands.states.snapshots import Snapshots, call_of
from rmfs_commands.trace.json_lines import JsonLinesFile, beside_results
from rmfs_core.events import Event
from rmfs_core.hookspecs import hookimpl
from rmfs_core.roles import Role
from rmfs_core.scenario import scenario_to_dict

if TYPE_CHECKING:
    from rmfs_core.info import Question, RunInfo

RECORDING_FILE = "decisions.jsonl.gz"
RECORDING_FORMAT = "rmfs-decisions"
RECORDING_VERSION = 1


class DecisionRecorder:
    """Observer that writes the decisions next to the results while the run goes on, and names the file at its end."""

    file: ClassVar = RECORDING_FILE

    def __init__(self) -> None:
        self._asked: dict[str, Any] | None = None
        self._fresh: dict[tuple[Role, str], Any] = {}

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Write the header."""
        self._file = JsonLinesFile(beside_results(run, self.file))
        self._run = run
        self._snapshots = Snapshots(run)
        self._file.write(
            {
                "format": RECORDING_FORMAT,
                "version": RECORDING_VERSION,
                "scenario": json_ready(scenario_to_dict(run.scenario)),
                "state": self._snapshots.state,
            }
        )

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep up with orders and pods."""
        self._snapshots.told(event)

    def corrected(self, orders: Iterable[int], pods: Iterable[int]) -> None:
        """Keep up with orders and pods that no event tells of."""
        self._snapshots.corrected(orders, pods)

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Take down what a rule sees that is about to be asked."""
        decides = question.decides
        if decides not in DECIDING:
            return
        call = call_of(question)
        generator = question.rng.bit_generator.state
        if generator != self._fresh.setdefault((decides, question.rule), generator):
            call["random"] = generator_state(generator)
        change = self._snapshots.look(call)
        self._asked = {"decides": decides.label, "rule": question.rule, "change": change, "decision": None}

    @hookimpl
    def rule_answered(self, question: Question, answer: object) -> None:
        """Take down what the rule answered that was asked last."""
        if self._asked is None:
            return
        asked = question.decides, answer, question.arguments
        decision = answer_to_dict(self._run.warehouse, self._run.instance.skus, *asked)
        report = None if decision is None else decision.pop("report", None)
        self._asked["decision"] = decision
        if report is not None:
            self._asked["report"] = report
        self._flush()

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:  # noqa: ARG002
        """Give the file its name. A rule that was asked and failed leaves what it saw."""
        self._flush()
        self._file.commit()

    def _flush(self) -> None:
        if self._asked is not None:
            self._file.write(self._asked)
            self._asked = None


def generator_state(generator: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state of a random generator as a state tells it."""
    return {
        "state": str(generator["state"]["state"]),
        "increment": str(generator["state"]["inc"]),
        "has_uint32": generator["has_uint32"],
        "uinteger": generator["uinteger"],
    }
