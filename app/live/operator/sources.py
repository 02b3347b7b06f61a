"""What the page server serves: the page of a run, and a desk at which people start tasks."""

from pathlib import Path
from typing import Any, NamedTuple, Protocol

from app.live.changes import LogBook

Told = dict[str, Any]
"""Something for the browser, as JSON."""


class Page(Protocol):
    """What a page server shows: of a run in this process, or in another."""

    log: LogBook

    @property
    def viewer_hosts(self) -> str:
        """To which the viewer on the page may connect."""

    def about(self) -> Told:
        """What does not change; the same object until it does."""

    def state(self) -> Told:
        """What changes all the time; `phase` and `stopped` at least."""

    def picture(self) -> Told | None:
        """The last picture of the camera; the same object until there is another."""

    def catch_up(self) -> None:
        """Called a few times a second, whether or not anybody watches."""

    def act(self, path: str) -> bool:
        """Do what a button asks for by its path; whether there is such a button."""

    def stop(self) -> None:
        """End the run; may be called again."""


class Document(NamedTuple):
    """A file for the browser."""

    content: bytes | Path
    kind: str
    policy: str = ""


class Desk(Protocol):
    """What `frankie-task serve` adds to the page: tasks to start, and runs to look at."""

    def get(self, path: str) -> Document | None:
        """The document at a path; None if there is none."""

    def post(self, path: str, body: bytes) -> Told | None:
        """Check or start a task; None if the path is neither."""
