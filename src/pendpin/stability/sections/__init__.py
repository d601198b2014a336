"""Sections of a motion: its states where a quantity crosses a level (Poincaré) or once a period (stroboscopic).

A section is a function of a scene, or of a run: it continues the motion until it has all its points. Collected over
many starts of one energy it is a portrait; over a number of the scene, with the state carried on, a bifurcation diagram.
May import: what stability may.
"""

from pendpin.stability.sections.diagrams import Bifurcation, Portrait, bifurcation, portrait
from pendpin.stability.sections.points import Crossing, Strobe, crossing, strobe

__all__ = ["Bifurcation", "Crossing", "Portrait", "Strobe", "bifurcation", "crossing", "portrait", "strobe"]
