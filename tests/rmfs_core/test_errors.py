"""What can go wrong, by who has to mend it."""

from __future__ import annotations

import pytest

from rmfs_commands.cli.main import main
from rmfs_core.errors import InputError, RmfsError, RuleError, RunError, StandstillError, is_interrupt


def test_an_input_error_is_a_place_and_a_problem() -> None:
    """Both stay apart, so that who knows the file better can name the place anew."""
    error = InputError("scenario.toml, line 3, robots.count", "expected a whole number >= 1, found 0")
    assert str(error) == "scenario.toml, line 3, robots.count: expected a whole number >= 1, found 0"
    assert (error.place, error.problem) == (
        "scenario.toml, line 3, robots.count",
        "expected a whole number >= 1, found 0",
    )


@pytest.mark.parametrize(
    ("error", "code"),
    [(InputError("a", "b"), 2), (RunError("a"), 1), (RuleError("a"), 1), (StandstillError("a"), 1), (RmfsError(), 1)],
)
def test_exit_codes_tell_wrong_input_from_a_run_that_failed(error: RmfsError, code: int) -> None:
    """2: the input is wrong; 1: anything else that is raised on purpose."""
    assert error.exit_code == code


def test_a_command_ends_with_the_sentence_and_the_code(capsys: pytest.CaptureFixture[str]) -> None:
    """No traceback: one line for who made the mistake."""
    with pytest.raises(SystemExit) as stop:
        main(["scenario", "check", "paper-25"])
    assert stop.value.code == 2
    printed = capsys.readouterr()
    assert "paper-25: there is no such file" in printed.out + printed.err
    assert "Traceback" not in printed.out + printed.err


def test_a_run_error_can_carry_what_was_measured() -> None:
    """Nothing unless a run puts its result there."""
    assert RuleError("a").result is None


def test_an_interrupt_is_known_in_what_python_makes_of_it() -> None:
    """One within compiled code is a SystemError, with the interrupt as its cause; any other SystemError is none."""
    within = SystemError("returned a result with an exception set")
    assert not is_interrupt(within)
    within.__cause__ = KeyboardInterrupt()
    assert is_interrupt(within)
    assert is_interrupt(KeyboardInterrupt())
    assert not is_interrupt(None)
