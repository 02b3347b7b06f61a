"""Those who are told about a run: recording, log, page, terminal. None of them can end it."""

from __future__ import annotations

from collections.abc import Callable


class Observers:
    """Calls observers, each on its own: one that raises is told once and not called again."""

    def __init__(self) -> None:
        self._failed: dict[str, str] = {}

    def tell(self, name: str, call: Callable[[], object]) -> None:
        """Call an observer, unless it has failed before.

        Args:
            name: what people call it.
            call: tells it something.
        """
        if name in self._failed:
            return
        try:
            call()
        except BaseException as error:  # whatever it is, the robot must go on
            self._failed[name] = f"{name} ended early ({type(error).__name__}: {error})"

    @property
    def failures(self) -> tuple[str, ...]:
        """What went wrong, one text for each observer that failed."""
        return tuple(self._failed.values())
