"""What comes out: the record of a run, its parts, and the file that holds it.

May import: the ground.
To add a result: a field in trajectory.py, its shape in reading.py, its name and unit in columns.py.
"""

from pendpin.trajectory.parts import KINDS, Counts, Energy, Event, Reactions, Stats, exchanged
from pendpin.trajectory.reading import event_arrays, read_array, read_events
from pendpin.trajectory.slicing import joined, samples_of
from pendpin.trajectory.trajectory import Trajectory
