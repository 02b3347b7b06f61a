"""`--jitter-ms`: how long control periods really last."""

from __future__ import annotations

from app.commands import refuse


def parse_jitter(given: str | None) -> tuple[float, float] | None:
    """Shortest and longest period [s], from milliseconds as in `5-30`."""
    if given is None:
        return None
    first, _, last = given.partition("-")
    try:
        shortest, longest = float(first) / 1e3, float(last) / 1e3
    except ValueError:
        shortest = longest = 0.0
    if not 0.0 < shortest <= longest <= 1.0:
        refuse(f"--jitter-ms {given}: give the shortest and the longest period, as 5-30")
    return shortest, longest
