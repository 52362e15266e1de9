"""The lowest versions that rmfs allows, as constraints for pip."""

from __future__ import annotations

from pathlib import Path

import pytest

from lowest import constraints, main

PYPROJECT = """
[project]
dependencies = ["numpy>=1.26", "numba>=0.59,<0.69", "lazy-loader >= 0.4"]
[project.optional-dependencies]
serve = ["uvicorn>=0.30"]
test = ["pytest>=8", "rmfs[serve]"]
"""


def test_each_dependency_at_its_lower_bound() -> None:
    """The optional ones, too, but for those that develop rmfs."""
    assert constraints(PYPROJECT) == ["numpy==1.26", "numba==0.59", "lazy-loader==0.4", "uvicorn==0.30"]


def test_a_dependency_without_a_lower_bound_is_refused() -> None:
    """Any version could be installed then."""
    with pytest.raises(ValueError, match=r'"numpy<3" has no lower bound; expected one such as "numpy>=1.26"'):
        constraints(PYPROJECT.replace(">=1.26", "<3"))


def test_those_of_the_checkout_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file of its own can be given."""
    assert main([]) == 0
    assert "attrs==" in capsys.readouterr().out
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    assert main([str(tmp_path / "pyproject.toml")]) == 0
    assert capsys.readouterr().out == "numpy==1.26\nnumba==0.59\nlazy-loader==0.4\nuvicorn==0.30\n"
