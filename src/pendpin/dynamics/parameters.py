"""The numbers of a scene as parameters of equations on a tape: another mass then needs no new code.

Zeros stay zeros and are simplified away: which numbers are 0 belongs to the structure of a scene, as do the kinds of its
effects.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from pendpin.effects import Effect
from pendpin.engines.machine.llvm import Table, Values
from pendpin.engines.machine.passes import recorded_by_rod
from pendpin.engines.machine.tape import Tape, recorded
from pendpin.errors import InputError
from pendpin.ground.arrays import Array, Mask
from pendpin.model.build import Model

AnEffect = TypeVar("AnEffect", bound=Effect)


@dataclass(eq=False)
class Numbers:
    """Passes numbers on unchanged: for equations on floats, or on what the functions xp take (pendpin.equations.base)."""

    by_rod = False  # whether the equations see one rod of a chain that may have any number of them
    xp: Any = np

    def __call__(self, x: Any) -> Any:
        """A number or an array of numbers as the equations see it; None stays None."""
        return x

    def per_rod(self, x: Array) -> Array:
        """Numbers (n, ...) of all joints or bodies, as `self(x)`; those of one rod's, (k, ...), if equations are by rod."""
        return self(x)

    def constant(self, x: Any) -> None:
        """Note what the equations take as it is."""

    def effect(self, effect: AnEffect) -> AnEffect:
        """The effect with its numbers passed through this object."""
        return effect


class Parameters(Numbers):
    """Replaces the numbers of a model by parameters of a tape and lists their values; without a tape it only lists them.

    `by_rod`: of n rods in a row with w joints each, whose equations are recorded for one rod: the same for every n. A number
    that is 0 for all rods is then 0 by structure. `masks` are, in the order of the calls, which numbers have a parameter:
    those that are not 0, or as given beforehand. Complex numbers stay complex in the lists (derivatives.py).
    """

    def __init__(
        self, model: Model, by_rod: bool = False, masks: Sequence[Mask] | None = None, tape: Tape | None = None
    ) -> None:
        super().__init__(np if tape is None else recorded_by_rod(tape) if by_rod else recorded())
        self.by_rod, self.tables, self.masks = by_rod, list[Table](), list[Mask]()
        self.rods = len(model.rods) if by_rod else 1  # what is recorded stands for so many, each with `width` joints
        self.width = len(model.joints) // self.rods
        self.shared, self.of_rods = list[Any](), list[Array]()  # the values, those of each rod (n,)
        self._fixed_masks, self._tape, self._structure = masks, tape, list[Hashable]()
        self._effects = dict[int, Any]()

    @property
    def structure(self) -> tuple[Hashable, ...]:
        """What has to agree for two scenes to have the same equations but for the values."""
        return tuple(self._structure)

    @property
    def values(self) -> Values:
        """The values of all parameters."""
        return Values(self.shared, np.array(self.of_rods).reshape(-1, self.rods), self.tables)

    def __call__(self, x: Any) -> Any:
        """The numbers with a parameter in place of each that is not 0."""
        if x is None:
            self._structure.append(None)
            return None
        values = _convert_to_numbers(x)
        return self._replace(values, values, values != 0, self.shared)[()]

    def per_rod(self, x: Array) -> Array:
        if not self.by_rod:
            return self(x)
        every = _convert_to_numbers(x).reshape(self.rods, -1, *np.shape(x)[1:])
        return self._replace(every[0], every, (every != 0).any(0), self.of_rods, by_rod=True)

    def _replace(self, values: Array, every: Array, mask: Mask, known: list, by_rod: bool = False) -> Any:
        """Numbers with a parameter in place of each in the mask, or the one given before; its values join the known."""
        present = mask if self._fixed_masks is None else self._fixed_masks[len(self.masks)]
        self.masks.append(present)
        self._structure.append((values.shape, present.tobytes()))
        begin = len(known)
        known += list(every[..., present].T)  # of a parameter of every rod an array (n,)
        if self._tape is None:
            return values
        out = np.where(present, 0.0, values).astype(object)
        out[present] = [self._tape.parameter(place, by_rod) for place in range(begin, len(known))]
        return out

    def constant(self, x: Any) -> None:
        self._structure.append(x.tobytes() if isinstance(x, np.ndarray) else x)

    def state(self, parts: int) -> Array:
        """A state (parts, w) of the tape, of so many numbers for each of the joints."""
        assert self._tape is not None
        shape = (self.width, parts) if self.by_rod else (parts * self.width,)
        return self._tape.state(*shape).reshape(parts, -1)

    def inputs(self, part: int) -> list[Any]:
        """The inputs of the tape in one part of them, one for each joint; their places are not in the structure."""
        if self._tape is None:
            return [0.0] * self.width
        places = ((part, i) if self.by_rod else (part * self.width + i,) for i in range(self.width))
        return [self._tape.term("input", *place, by_rod=self.by_rod) for place in places]

    def effect(self, effect: AnEffect) -> AnEffect:
        """The effect with parameters; its kind, and fields that are not numbers, belong to the structure."""
        if id(effect) not in self._effects:
            others = effect.model_copy(update=dict.fromkeys(effect.parameters))
            self.constant((type(effect), repr(others)))
            # both are kept: an id is good as long as its effect lives
            self._effects[id(effect)] = effect, effect.with_numbers(self)
        return self._effects[id(effect)][1]

    def table(self, times: Array, rows: Array) -> Callable[[Any], Array]:
        """A function for the row (width,) of those (n, width) that holds at a time, from its own (n,) to the next."""
        if np.iscomplexobj(rows):  # by derivatives.py
            raise InputError("effects: what a csv holds over time, and its axis, have no derivative")
        tape: Any = self._tape  # without one the function is not called
        place, width = len(self.tables), rows.shape[1]
        self.tables.append(Table(times, rows))
        self.constant(("table", width))
        return lambda t: tape.row(place, width, t)


def _convert_to_numbers(x: Any) -> Array:
    values = np.asarray(x)
    return values.astype(complex if values.dtype.kind == "c" else float)


GIVEN = Numbers()
