"""The simulation: it asks rules through hooks and turns their decisions into events."""
