"""Which of the usual rule sets serves a scenario best."""
