"""Profiles and pairs before a run: what a file is taken for, its measures, outlines in their places."""
