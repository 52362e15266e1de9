from rmfs_commands.testing import (
    ConformanceError as ConformanceError,
)
from rmfs_commands.testing import (
    ConformanceReport as ConformanceReport,
)
from rmfs_commands.testing import (
    Fault as Fault,
)
from rmfs_commands.testing import (
    Finding as Finding,
)
from rmfs_commands.testing import (
    check_rule as check_rule,
)
from rmfs_commands.testing import (
    conformance_report as conformance_report,
)
from rmfs_commands.testing import (
    small_instance as small_instance,
)
from rmfs_commands.testing import (
    small_layout as small_layout,
)
from rmfs_commands.testing import (
    small_world as small_world,
)
from rmfs_commands.testing import (
    validate_trace as validate_trace,
)
