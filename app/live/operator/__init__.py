"""Control of a run by people: pause, step, stop, breakpoints.

The session's loop asks `Control` every tick; keys, observers and hooks in the tree set it.
"""

from app.live.operator.control import Control
from app.live.operator.hooks import Hook, UnknownNodeError, insert_hooks, matching
from app.live.operator.keyboard import HELP, in_terminal, keys
