"""The displays of an experiment."""

import re
from collections.abc import Callable

from rich.console import Console

from rmfs_commands.experiments import Experiment
from rmfs_commands.experiments.progress import ExperimentLines, ExperimentPanel, experiment_display

Write = Callable[..., Experiment]


def test_plain_lines(experiment: Write) -> None:
    """A line at the start, for each tenth, for a run that is repeated or fails, and at the end."""
    console = Console(width=40, force_terminal=False)
    progress = ExperimentLines("trial", console)
    jobs = experiment().jobs()
    with console.capture() as capture:
        progress.started(5, 1, 2)
        progress.run_started(jobs[0])
        progress.run_repeated(jobs[0], "it died")
        progress.run_finished(jobs[0], {"status": "failed", "error": "no idea [of] it"})
        progress.run_started(jobs[1])
        progress.run_finished(jobs[1], {"status": "complete", "simulated_s": 100.0})
        progress.ended()
        progress.bounding(3)
    lines = capture.get().splitlines()
    assert lines[:3] == [
        "trial: 5 runs, 1 of them stored already, 2 at a time",
        "Repeated: tiny, pod-match, seed 1: it died",
        "Failed: tiny, pod-match, seed 1: no idea [of] it",
    ]
    assert lines[3].startswith(" 40 %  2 of 5 runs done, 1 failed, 0 running, - simulated s per s, ")
    assert lines[3].endswith(" left")
    assert lines[4].startswith(" 60 %  3 of 5 runs done, 1 failed, 0 running, ")
    assert lines[5].startswith("3 of 5 runs done, 1 failed, 0 running, ")
    assert lines[6:] == ["trial: bounds of 3 instances and seeds"]


def test_no_more_runs_are_under_way_than_there_are_slots(experiment: Write) -> None:
    """Though a run is begun as soon as another has ended, before that is counted."""
    console = Console(width=80, force_terminal=False)
    progress = ExperimentLines("trial", console)
    with console.capture() as capture:
        progress.started(8, 0, 2)
        for job in experiment().jobs()[:3]:
            progress.run_started(job)
        progress.ended()
    assert "2 running" in capture.get()


def test_the_live_display(experiment: Write) -> None:
    """It shows runs done and under way, speed and time left; failures stay to be read when it is gone."""
    console = Console(width=100, height=40, force_terminal=True, color_system=None)
    progress = ExperimentPanel("trial", console)
    jobs = experiment().jobs()
    with console.capture() as capture:
        progress.started(40, 10, 4)
        for job in jobs:
            progress.run_started(job)
        progress.run_finished(jobs[0], {"status": "complete", "simulated_s": 100.0})
        progress.run_finished(jobs[1], {"status": "failed", "error": "no idea"})
        console.print(progress.picture())
        progress.ended()
        progress.bounding(3)
    text = capture.get()
    assert text.endswith("trial: bounds of 3 instances and seeds\n")
    assert "12 of 40 (30%)" in text
    assert "2 of 4 at a time" in text
    assert re.search(r"Ends in about +0:0\d:\d\d ", text)
    assert "first-come" in text
    assert "Failed: tiny, pod-match, seed 2: no idea" in text
    assert max(len(line) for line in text.splitlines() if line.startswith("│")) <= 100


def test_the_display_suits_where_it_goes() -> None:
    """Live on a terminal, lines elsewhere."""
    assert isinstance(experiment_display(Console(force_terminal=True), "x"), ExperimentPanel)
    assert isinstance(experiment_display(Console(force_terminal=False), "x"), ExperimentLines)
