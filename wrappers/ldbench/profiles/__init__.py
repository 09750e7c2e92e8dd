"""Wheels and rails from any file: read, placed, mended, smoothed, measured."""
