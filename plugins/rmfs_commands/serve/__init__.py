"""The decision service: rules that stay loaded and answer states, over HTTP or as JSON lines."""
