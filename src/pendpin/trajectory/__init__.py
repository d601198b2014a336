"""What comes out: the record of a run, its parts, and the file that holds it.

May import: the ground.
To add a result: a field in record.py, its shape in parts.py, its name and unit in columns.py.
"""

from pendpin.trajectory.parts import Counts, Derived, Event, HingeReactions, Reactions, Stats, exchanged
from pendpin.trajectory.record import RunRecord, joined, samples_of, with_samples
