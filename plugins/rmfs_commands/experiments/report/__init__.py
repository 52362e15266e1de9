"""Reports of an experiment for people and for other programs."""

from rmfs_commands.experiments.report.files import (
    PARQUET_FILE,
    PLOTS_FOLDER,
    REPEATING_FILE,
    REPORT_FILE,
    SUMMARY_FILE,
    TABLES_FOLDER,
    write_report,
)
from rmfs_commands.experiments.report.terminal import print_comparison

__all__ = [
    "PARQUET_FILE",
    "PLOTS_FOLDER",
    "REPEATING_FILE",
    "REPORT_FILE",
    "SUMMARY_FILE",
    "TABLES_FOLDER",
    "print_comparison",
    "write_report",
]
