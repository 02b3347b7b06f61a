"""Control from the watching side: pause, step, stop, breakpoints and faults, while a task runs.

`Control` is what the session asks every tick; terminal keys, the page in the browser and Groot2
tell it what people want.
"""

from app.control.control import Control, ControlState
from app.control.faults import INJECTABLE, FaultyRobot
from app.control.hooks import Act, Hook, Side, UnknownNodeError, insert_hooks, matching
from app.control.keyboard import keys
from app.control.task_clock import TaskClock

__all__ = [
    "INJECTABLE",
    "Act",
    "Control",
    "ControlState",
    "FaultyRobot",
    "Hook",
    "Side",
    "TaskClock",
    "UnknownNodeError",
    "insert_hooks",
    "keys",
    "matching",
]
