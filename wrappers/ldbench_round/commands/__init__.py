"""The commands of a round, a module each, as those of `ldbench.commands`."""
