"""The shipped commands, recorders and observers, a package each; and what commands share."""
