"""Parts that a third party adds to rmfs, through entry points and hooks alone."""
