"""How people are told the time of a run: the task's own, and beside it how long it was paused.

Terminal, page, `runs`, `explain` and report all say it with these words.
"""

from __future__ import annotations


def task_time(seconds: float, paused_s: float = 0.0) -> str:
    """As `57.3 s, paused 4 min 57 s`.

    Args:
        seconds: of the task, from its first tick, pauses left out [s].
        paused_s: how long it was paused in all [s].
    """
    paused = f", paused {in_words(paused_s)}" if paused_s >= 1.0 else ""
    return f"{seconds:.1f} s{paused}"


def in_words(seconds: float) -> str:
    """A length of time in whole seconds, as `4 min 57 s`."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = (f"{hours} h" * bool(hours), f"{minutes} min" * bool(hours or minutes), f"{rest} s")
    return " ".join(part for part in parts if part)
