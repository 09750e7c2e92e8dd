"""The PDF of plots: every quantity of the benchmark's list against time, for each run.

A page shows a quantity over the whole run and, beside it, around the first contact of
the left flange.  A long run of many rattling impacts (exercise 5) is drawn as the band between
smallest and largest value, and its last second beside it.  Every page is drawn by one function that returns a figure;
each kind of page has its module, `style` its colours and lines.
"""
from .document import Part, bind, case_figures, drawing, make_plots, save_pages
from .figures import by_pair, derailment_figure, impact_figure, motion_figure
from .frame import DEG, KN, MM, label_x, label_y, new_page
from .geometry import geometry_page
from .phase import phase_page
from .quantities import IMPULSES, PAGES, Curve, Page, Panel
from .sections import instants, section_page
from .stretches import band, first_episode, thin, windows
from .summary import SUMMARY_LINES, SUMMARY_NOTE, summary_page
from .times import time_page

__all__ = [
    "DEG", "IMPULSES", "KN", "MM", "PAGES", "SUMMARY_LINES", "SUMMARY_NOTE", "Curve", "Page", "Panel", "Part", "band",
    "bind", "by_pair", "case_figures", "derailment_figure", "drawing", "first_episode", "geometry_page",
    "impact_figure", "instants", "label_x", "label_y", "make_plots", "motion_figure", "new_page", "phase_page",
    "save_pages", "section_page", "summary_page", "thin", "time_page", "windows"]
