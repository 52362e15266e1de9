"""What an experiment leaves behind for people and for other programs."""

from rmfs_experiments.report.terminal import print_comparison
from rmfs_experiments.report.writing import PARQUET_FILE, PLOTS_FOLDER, REPORT_FILE, SUMMARY_FILE, write_report

__all__ = ["PARQUET_FILE", "PLOTS_FOLDER", "REPORT_FILE", "SUMMARY_FILE", "print_comparison", "write_report"]
