"""The kit for authors of rules: a distribution of one's own, written from templates that work as they are."""

from rmfs_core.kit.names import NewRule
from rmfs_core.kit.project import project_files, selecting, write_project

__all__ = ["NewRule", "project_files", "selecting", "write_project"]
