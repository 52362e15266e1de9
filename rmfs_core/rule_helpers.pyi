from rmfs_rule_helpers import (
    OVERSIZE_WAIT_S as OVERSIZE_WAIT_S,
)
from rmfs_rule_helpers import (
    assign_best_pairs as assign_best_pairs,
)
from rmfs_rule_helpers import (
    items_per_order as items_per_order,
)
from rmfs_rule_helpers import (
    largest_capacity as largest_capacity,
)
from rmfs_rule_helpers import (
    lines_at as lines_at,
)
from rmfs_rule_helpers import (
    nearest_free_location as nearest_free_location,
)
from rmfs_rule_helpers import (
    pod_at as pod_at,
)
from rmfs_rule_helpers import (
    send_pods as send_pods,
)
from rmfs_rule_helpers import (
    sum_per_order as sum_per_order,
)
from rmfs_rule_helpers import (
    ticks_to_station as ticks_to_station,
)
from rmfs_rule_helpers import (
    waiting_limit as waiting_limit,
)
