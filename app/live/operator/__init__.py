"""Control from the watching side: pause, step, stop, breakpoints and faults, while a task runs.

`Control` is what the session asks every tick; terminal keys, the page in the browser and Groot2
tell it what people want.
"""

from app.live.operator.control import Control, ControlState
from app.live.operator.hooks import Act, Hook, Side, UnknownNodeError, insert_hooks, matching
from app.live.operator.keyboard import keys
from hw import INJECTABLE, FaultInjection, TaskClock

__all__ = [
    "INJECTABLE",
    "Act",
    "Control",
    "ControlState",
    "FaultInjection",
    "Hook",
    "Side",
    "TaskClock",
    "UnknownNodeError",
    "insert_hooks",
    "keys",
    "matching",
]
