"""The command itself, `rmfs run` and its neighbours ``rules``, ``scenario`` and ``generate``; and what commands share."""
