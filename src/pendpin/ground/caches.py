"""What was computed lately, kept for the next who asks."""

from collections.abc import Callable, Hashable
from threading import local
from typing import Generic, TypeVar

T = TypeVar("T")


class ThreadCache(local, Generic[T]):
    """The results of the last few keys asked for. Each thread has its own, as what is kept may hold scratch memory."""

    def __init__(self, most: int) -> None:
        self._most, self._known = most, dict[Hashable, T]()

    def look_up(self, key: Hashable, make: Callable[[], T], lasts: Callable[[], bool] = lambda: True) -> T:
        """The result of a key, made if it is not known; what does not last, or has a key without a hash, is not kept."""
        try:
            known = self._known.pop(key, None)
        except TypeError:  # as of a user's own effect that holds a list
            return make()
        made = make() if known is None else known
        if known is not None or lasts():
            self._known[key] = made  # behind those that were not asked for since
        while len(self._known) > self._most:
            self._known.pop(next(iter(self._known)))
        return made

    def clear(self) -> None:
        """Forget everything that this thread knows."""
        self._known.clear()
