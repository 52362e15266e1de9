"""``python -m rmfs_core.cli`` is ``rmfs``."""

from rmfs_core.cli import main

main()
