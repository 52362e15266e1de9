"""Parameters of rules, searched for: `rmfs tune`."""
