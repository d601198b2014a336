"""What comes out: the record of a run, its parts, and the file that holds it.

May import: the ground.
"""

from pendpin.trajectory.parts import Counts, Energy, Reactions, Stats
from pendpin.trajectory.reading import read_array
from pendpin.trajectory.samples import joined, samples_of
from pendpin.trajectory.trajectory import Trajectory

__all__ = ["Counts", "Energy", "Reactions", "Stats", "Trajectory", "joined", "read_array", "samples_of"]
