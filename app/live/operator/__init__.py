"""Control of a run by people: pause, step, stop, breakpoints, and injected faults.

The session's loop asks `Control` every tick; keys, the control page and hooks in the tree set it.
"""

from app.live.operator.control import ACKNOWLEDGED, Control
from app.live.operator.hooks import Hook, UnknownNodeError, insert_hooks, matching
from app.live.operator.keyboard import HELP, in_terminal, keys
from app.live.operator.page import ControlPage, Told
from app.live.operator.page_pipe import PagePipe
from app.live.operator.page_server import Desk, Document, PageError, PageServer
from app.live.operator.run_process import RunProcess
