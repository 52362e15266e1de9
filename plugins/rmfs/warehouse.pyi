from rmfs_core.warehouse import *  # noqa: F403
