"""Sentences of reports on the limits of the simulation."""

from __future__ import annotations

NOT_SIMULATED_PAGE = "What is not simulated"
"""Title of the page in the documentation: who reads a report may have no copy of the repository."""
NOT_SIMULATED = (
    "Not simulated, among others: breaks, errors, people in each other's way. Which way that errs: "
    f"see {NOT_SIMULATED_PAGE} in the documentation."
)
"""The sentence at the end of each report."""
