"""What was computed lately, kept for the next who asks."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import local
from typing import Generic, TypeVar

T = TypeVar("T")


class ThreadCache(local, Generic[T]):
    """The results of the last few keys asked for. Each thread has its own, as what is kept may hold scratch memory."""

    def __init__(self, most: int) -> None:
        self._most, self._known = most, OrderedDict[Hashable, T]()

    def look_up(self, key: Hashable, make: Callable[[], T]) -> T:
        """The result of a key, made if it is not known."""
        if key not in self._known:
            self._known[key] = make()
            while len(self._known) > self._most:
                self._known.popitem(last=False)
        self._known.move_to_end(key)
        return self._known[key]

    def clear(self) -> None:
        """Forget everything that this thread knows."""
        self._known.clear()
