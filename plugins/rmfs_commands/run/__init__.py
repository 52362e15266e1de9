"""The command ``rmfs run``: a scenario, simulated, shown and kept."""
