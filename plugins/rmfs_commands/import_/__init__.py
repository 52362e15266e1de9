"""``rmfs import``: files of other simulators and benchmarks to a scenario, a text map and CSV files."""
