"""Results of a run: tables made from its events, what observers measured, and the files of both."""

from rmfs_core.results.result import RESULT_FILE, Result

__all__ = ["RESULT_FILE", "Result"]
