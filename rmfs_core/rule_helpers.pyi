from rmfs_rule_helpers import *  # noqa: F403
