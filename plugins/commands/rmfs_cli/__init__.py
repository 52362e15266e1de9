"""The command line; ``run``, ``rules``, ``scenario``, ``generate``, which run and describe; and what commands share."""
