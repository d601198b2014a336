"""What is loaded when it is called: functions of higher rooms that records offer, and libraries that need not be there.

Imports point one way. A trajectory is a record that every room uses, so it cannot import the rooms that integrate, draw or
show; yet users ask a run for run.at(t) and run.plot(). This table is the one exception: it names these functions, and
nothing else reaches upward (tests/test_architecture.py holds both).
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from pendpin.errors import MissingLibrary

HOMES = {
    "Diagnosis.harm": "analysis.doctor.reports.harm:harm_of",
    "Diagnosis.text": "analysis.doctor.reports.text:text",
    "Diagnosis.to_json": "analysis.doctor.reports.text:records",
    "Fit.plot": "analysis.fit.figure:plot",
    "Start.at_rest": "simulation.starts:at_rest",
    "Start.conical": "simulation.starts:conical",
    "Trajectory.animate": "graphics.animation:Animation",
    "Trajectory.at": "simulation.continuation:at",
    "Trajectory.configurations": "model.configurations:configurations",
    "Trajectory.crossings": "simulation.crossings:crossings",
    "Trajectory.extend": "simulation.continuation:extend",
    "Trajectory.page": "graphics.animation:frame_of",
    "Trajectory.plot": "graphics.figure:plot",
    "Trajectory.show": "graphics.viewers:show",
    "Trajectory.slides": "model.of_run:slides_of",
    "Trajectory.swings": "model.of_run:swings_of",
}


def from_above(name: str) -> Callable[..., Any]:
    """The function that does the work of a method."""
    module, function = HOMES[name].split(":")
    return getattr(import_module(f"pendpin.{module}"), function)


def optional(library: str, what: str, package: str) -> Any:
    """A library that need not be installed. Raises MissingLibrary, which says what needs it and which package brings it."""
    try:
        return import_module(library)
    except ImportError:
        raise MissingLibrary(f"{what} needs {library.partition('.')[0]}: pip install {package}") from None
