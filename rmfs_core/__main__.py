"""``python -m rmfs_core``: the command line."""

from rmfs_core.cli import main

main()
