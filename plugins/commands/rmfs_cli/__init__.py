"""The commands that run and describe: ``run``, ``rules``, ``scenario``, ``generate``; and what commands share."""
