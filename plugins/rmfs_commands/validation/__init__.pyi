from .checking import Report, check_trace, validate_trace
from .fault import KINDS, Fault
from .validator import faults_of

__all__ = ["KINDS", "Fault", "Report", "check_trace", "faults_of", "validate_trace"]
