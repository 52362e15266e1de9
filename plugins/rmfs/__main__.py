"""``python -m rmfs``: the command line."""

from rmfs_commands.cli.start import main

main()
