from rmfs_rules.helpers import *  # noqa: F403
