"""Figures of runs, profiles and contact geometry, with matplotlib.

A page shows a quantity over the whole run and, beside it, around the first contact of the left flange. A long run of many rattling
impacts (exercise 5) is drawn as the band between smallest and largest value, and its last second beside it. Every page is drawn by
one function that returns a figure; `style` has colours and lines.
"""
