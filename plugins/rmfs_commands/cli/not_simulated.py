"""Sentences of reports on the limits of the simulation."""

from __future__ import annotations

NOT_SIMULATED_PAGE = "What is not simulated"
"""Title of the page in the documentation: who reads a report may have no copy of the repository."""
NOT_SIMULATED = (
    "Breaks, errors and people in each other's way, among others, are not simulated; "
    f"{NOT_SIMULATED_PAGE} in the documentation says how that changes results."
)
"""The sentence at the end of each report."""
