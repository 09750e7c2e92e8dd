"""Figures of runs, profiles and contact geometry, with matplotlib.

The sheets of a run show every quantity over the whole run and, beside it, in the first contact of either flange; other pages show
what the call does not ask for. Every page is drawn by one function that returns a figure, and every artist with data says what it
shows (`named`); `style` has colours and lines.
"""
