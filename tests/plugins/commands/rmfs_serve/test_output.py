"""What belongs on standard output, and what does not."""

from __future__ import annotations

import os

import pytest

from rmfs_serve.output import kept_for_answers


def test_what_else_is_printed_goes_to_standard_error(capfd: pytest.CaptureFixture[str]) -> None:
    """Python's prints and those of libraries below; afterwards everything is as before."""
    print("before")
    with kept_for_answers() as answers:
        print("from a rule")
        os.write(1, b"from a solver\n")
        answers.write(b"answer\n")
    print("after")
    out, err = capfd.readouterr()
    assert out == "before\nanswer\nafter\n"
    assert sorted(err.splitlines()) == ["from a rule", "from a solver"]
