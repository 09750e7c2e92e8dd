"""Rounds of the benchmark: what participants and organisers need."""
