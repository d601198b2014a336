"""The numbers of the search for an accuracy: where each comes from, and what it protects.

benchmarks/goal.py is the measure of all of them together: on random scenes of every kind and method no claim may be false,
and at most 3 % of the refusals within reach. Run it with a new seed after any change here. "Chosen" stands where a number
follows from no measurement: what it protects holds for values several times larger and smaller.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class SettingThresholds:
    """The settings of one method from coarse to fine (runs.py)."""

    # Tolerance of a first run, at most: looser ones give runs that have nothing in common with the motion.
    loosest: float = 1e-2
    # The first tolerance over the target, of series 10 times as much: a step's error is some hundredth of what it does until
    # the end, and the first two of three runs are coarser than the one that has to meet the target.
    first_tolerance: float = 100.0
    first_tolerance_of_series: float = 1e3
    # The first tolerance over the least: three different settings then remain even for the finest targets.
    room: float = 1e4
    # Of one run, times the price of a step: two minutes for one rod.
    most_steps: float = 1e7
    # Rounding of a number of steps, below which it is a whole number.
    whole: float = 1.0 - 1e-9
    # The target below which series are taken wherever they can be: other methods end at rounding.
    for_series: float = 1e-12


@dataclass(frozen=True)
class SampleThresholds:
    """The times at which runs are compared (runs.py)."""

    # Intervals at least: at two output times a run that has lost the phase may be right by chance.
    intervals: int = 64
    # Samples that are compared, at most: of many an error, which grows with the motion, shows in some as in all.
    most: int = 128
    # How often samples are doubled until a run differs from the one before: other output times change its steps.
    doublings: int = 3
    # rad, of differences that give speeds: far above the rounding of an angle of a million turns, far below a radian.
    step: float = 1e-3


@dataclass(frozen=True)
class EstimateThresholds:
    """How errors are estimated from the gaps of three runs (estimate.py)."""

    # Chosen: half of the expected power. Gaps that fall more slowly do not follow the order of the method.
    slowest: float = 0.5
    # Chosen, of the motion: two runs that have both lost the phase are about a whole motion apart.
    small: float = 0.1
    # Times the larger gap: the error of runs that agree but not as their order promises. Chosen.
    disagreement: float = 10.0
    # Of large gaps that still fall: below, the coarse runs have nothing in common at their ends. Chosen.
    smallest_fall: float = 2.0
    # Times the rounding: gaps below are made of rounding errors and need not fall. Chosen.
    noise: float = 4.0
    # Of the target: smaller gaps need not be small compared with the motion, such as that of a rod that hangs almost still.
    negligible: float = 1e-3
    # The same for runs that cannot be finer: no better evidence will come.
    negligible_at_finest: float = 0.1


@dataclass(frozen=True)
class SearchThresholds:
    """Which setting comes next (target.py)."""

    # How much smaller than the last error the next may be: a longer stride trusts the power law too far. Chosen.
    farthest: float = 1e4
    # The power of the promised factor by which gaps fall as a rule, on random scenes (benchmarks/goal.py).
    likely: float = 0.85
    # By which the next error should be below the target: the estimate is an upper bound. Chosen to save one more run.
    margin: float = 4.0
    # Of the target: a bound on rounding that needs no measurement. Chosen: it takes at most this part of the claim.
    harmless: float = 0.1


@dataclass(frozen=True)
class RoundingThresholds:
    """How rounding is measured (estimate.py); benchmarks/rounding_estimates.py compares it with exact motions."""

    # Units of rounding of the start, with a margin for directions in which shifts are magnified less.
    start_units: float = 4.0
    # Of sqrt(steps), each of the 16 later shifts: the steps err like a random walk. With it the estimate is 1.2 times the
    # true error or more on 400 exact motions, 50 times in the middle (benchmarks/rounding_estimates.py).
    step_units: float = 0.3
    # Of sqrt(steps) over the path: the same walk, where the shifts cancel. Of 24 swings of up to 2.5 rad and 1,000 s by the
    # finest series, one true error was 1.6 times the estimate without it; with it 0.35 times is the most.
    walk_units: float = 0.5
    # Units of rounding in the time that the motion takes, from the rounded numbers of the model: g, l and m of a rod
    # enter its rate once each.
    model_units: float = 4.0
    # Of the length: the largest distance of two runs that is in proportion to the shifts. Chosen.
    linear: float = 0.05
    # Ratio of the shifts to the rounding errors, unless the motion magnifies them too much: far above the rounding of the
    # shifted run itself, far below what changes the motion.
    enlargement: float = 1e5
    # At least so many shifts after the start. A swing from near upright passes the bottom, where shifts count most, once
    # in some seconds.
    later_shifts: int = 16
    # At which the rounding of the accelerations is measured. Chosen.
    states: int = 32
    # Of the target: the shifts of the first run, so that their effect stays within it; and the same at most.
    first_shift: float = 0.5
    largest_first_shift: float = 1e-7
    # Steps of the first run, about. Chosen: they only scale the rounding of the accelerations.
    first_steps: int = 100


@dataclass(frozen=True)
class InstabilityThresholds:
    """When a motion magnifies errors so much that they follow no law, and which evidence is then needed (target.py)."""

    # Rounding error of a motion that magnifies errors ten thousand times: no claim is below `negligible`.
    unstable: float = 1e-11
    # Rounding error of a motion that magnifies errors a hundred times and more.
    growing: float = 1e-13
    # Times the path over the length: faster growth is that of an instability. The error of a steady motion grows with its
    # path: 4 times it in the middle, 49 times at most, close to upright (benchmarks/rounding_estimates.py).
    steady_growth: float = 40.0
    # Times the error that the gaps of an unstable motion give. benchmarks/goal.py measured up to 5.1 near unstable rests.
    safety: float = 6.0
    # Times the distance of a run with other steps: the error of an unstable motion. Chosen.
    other_steps: float = 4.0
    # Times the target: rounding of a coarse run that no finer run needs to confirm. Chosen.
    hopeless: float = 10.0
    # Tolerance of a run whose motion is as stable as the true one: coarse runs gain energy and turn over.
    sure: float = 1e-12


@dataclass(frozen=True)
class ComparisonThresholds:
    """The run of another method, or of other steps, beside that of the search (target.py)."""

    # The least tolerance: ten times that of the methods, so that it is not made of rounding alone.
    least_tolerance: float = 1e-13
    # Of the target, over what the motion magnifies errors by: the tolerance, at most. Chosen: its error is then small
    # beside the target.
    of_target: float = 1e-3
    # Steps of a run beside that of effects that do not declare that they are smooth: half a second in Python.
    short_steps: float = 4096.0
    # Times its distance: the error, at least. Chosen; where nothing is missed the estimate is larger.
    short: float = 2.0


@dataclass(frozen=True)
class VectorThresholds:
    """Targets of many cases at once, by series at ever finer tolerances (sweeps/cases.py)."""

    # Finer targets are near to rounding, which only the search for one case measures.
    finest: float = 1e-9
    # The first tolerance over the target, and by how much the next is finer: three runs then meet most targets.
    coarser: float = 10.0
    finer: float = 100.0
    # Series, each compiled once: what five do not meet is left to the search for one case. Chosen.
    most_series: int = 5
    # Of its tolerance: the least error of a step of the series, which jumps with its order; rounding beside it is seen.
    step_error: float = 1e-3


SETTING = SettingThresholds()
SAMPLE = SampleThresholds()
VECTOR = VectorThresholds()
ESTIMATE = EstimateThresholds()
SEARCH = SearchThresholds()
ROUNDING = RoundingThresholds()
INSTABILITY = InstabilityThresholds()
COMPARISON = ComparisonThresholds()
