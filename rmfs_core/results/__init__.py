"""What a run leaves behind: metrics and tables made from its events, and the files they are written to."""

from rmfs_core.results.metrics import Metrics
from rmfs_core.results.result import RESULT_FILE, TABLE_FILES, Result, load_result
from rmfs_core.results.tables import Tables

__all__ = ["RESULT_FILE", "TABLE_FILES", "Metrics", "Result", "Tables", "load_result"]
