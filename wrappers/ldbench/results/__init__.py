"""Results of runs: columns, headers, events, and what quantities are called."""
