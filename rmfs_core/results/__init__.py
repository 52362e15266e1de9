"""What a run leaves behind: tables made from its events, what observers measured, and the files of both."""

from rmfs_core.results.result import Result
from rmfs_core.results.tables import RESULT_FILE, TABLE_FILES, Tables

__all__ = ["RESULT_FILE", "TABLE_FILES", "Result", "Tables"]
