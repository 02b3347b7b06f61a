"""How much of the machine this process holds: memory, threads, open handles."""

from dataclasses import dataclass
from os import listdir, sysconf
from pathlib import Path

__all__ = ["Footprint", "footprint"]


@dataclass(frozen=True)
class Footprint:
    """What the process holds at one moment."""

    rss: int
    """Resident memory [bytes]."""
    threads: int
    """Threads of the whole process, those of native libraries included."""
    handles: int
    """Open file descriptors: files, sockets, pipes."""


def footprint() -> Footprint:
    """What this process holds now, as Linux counts it.

    Raises:
        OSError: There is no /proc on this machine.
    """
    resident_pages = int(Path("/proc/self/statm").read_text().split()[1])
    return Footprint(
        rss=resident_pages * sysconf("SC_PAGE_SIZE"),
        threads=len(listdir("/proc/self/task")),
        # The listing itself holds one handle while it is read.
        handles=len(listdir("/proc/self/fd")) - 1,
    )
