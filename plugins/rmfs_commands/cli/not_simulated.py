"""Sentences of reports on the limits of the simulation."""

from __future__ import annotations

NOT_SIMULATED_PAGE = "docs/explanation/what-is-not-simulated.md"
"""The page, in the repository."""
NOT_SIMULATED = (
    "Not simulated, among others: breaks, errors, people in each other's way. Which way that errs: "
    f"{NOT_SIMULATED_PAGE}."
)
"""The sentence at the end of each report."""
