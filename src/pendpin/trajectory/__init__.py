"""What comes out: the record of a run, its parts, and the file that holds it.

May import: the ground.
To add a result: a field in trajectory.py, its shape in reading.py, its name and unit in columns.py.
"""

from pendpin.trajectory.parts import Counts, Energy, Reactions, Stats, exchanged
from pendpin.trajectory.reading import read_array
from pendpin.trajectory.samples import joined, samples_of
from pendpin.trajectory.trajectory import Trajectory

__all__ = ["Counts", "Energy", "Reactions", "Stats", "Trajectory", "exchanged", "joined", "read_array", "samples_of"]
