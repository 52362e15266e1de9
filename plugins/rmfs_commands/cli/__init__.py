"""The command line; ``rules``, ``scenario``, ``generate``, which describe; and what commands share."""
