"""Formats the time of a run: that of the task, and how long it was paused."""


def task_time(seconds: float, paused_s: float = 0.0) -> str:
    """Task time and pauses [s] as text, for example `57.3 s, paused 4 min 57 s`."""
    paused = f", paused {in_words(paused_s)}" if paused_s >= 1.0 else ""
    return f"{seconds:.1f} s{paused}"


def in_words(seconds: float) -> str:
    """A duration in whole seconds as text, for example `4 min 57 s`."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = (f"{hours} h" * bool(hours), f"{minutes} min" * bool(hours or minutes), f"{rest} s")
    return " ".join(part for part in parts if part)
