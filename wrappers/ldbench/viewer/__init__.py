"""Runs on the screen: the interactive page, films and pictures."""
