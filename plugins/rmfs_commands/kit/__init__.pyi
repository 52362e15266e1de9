from .names import NewRule
from .project import project_files, selecting, trying, write_project

__all__ = ["NewRule", "project_files", "selecting", "trying", "write_project"]
