"""Operator console: combines keys, breakpoints and observers of one run.

Keys are heard where standard input is a terminal and this process is in its foreground.
"""

from __future__ import annotations

import os
import select
import termios
import tty
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress

from py_trees.behaviour import Behaviour

from app.live.control import Control
from app.live.hooks import Hook, insert_hooks, matching
from app.live.observers import Observer
from app.live.run_snapshot import Snapshot
from app.run_options import RunOptions
from config import UserError
from hw import HardwareError, begun
from trees.language import TreeNode

HELP = (
    "space: pause   r: resume   s: step   n: run to the next status change   q: stop   "
    "a: acknowledge an emergency stop"
)


class OperatorConsole(Observer):
    """Controls of one run: `control`, and the tree from `root` on with `hooks`.

    `watched` is whether every node gets a hook, for observers; `say` prints a line. Raises
    UserError: there is no node to pause at.
    """

    def __init__(
        self,
        options: RunOptions,
        nodes: Sequence[TreeNode],
        *,
        watched: bool,
        say: Callable[[str], None],
    ) -> None:
        self.control = Control(paused=options.paused)
        self.left = False
        """Whether a person has ended everything, as by Ctrl-C."""
        self._options, self._say = options, say
        self._over_since: float | None = None
        self._emergency = ""
        stops = {node for wanted in options.breaks for node in matching(nodes, wanted)}
        every = [node.node for node in nodes]
        asks = {node for node in every if options.approve and _moves(node)}
        hooked = every if watched else [one for one in every if one in stops | asks]
        self.root, self.hooks = insert_hooks(nodes[0].node, hooked, self._reached)
        for hook in self.hooks:
            hook.asks, hook.stops = hook.node in asks, hook.node in stops

    def attend(self, observers: Iterable[Observer]) -> None:
        """Settle who can resume; raises UserError for a run that waits for nobody."""
        options, there = self._options, tuple(observers)
        has_keys, stand_in = in_terminal(0), options.acknowledge_after is not None
        self.control.attended = has_keys or stand_in or any(one.acknowledges for one in there)
        waits = options.paused or options.breaks or options.approve
        if waits and not (has_keys or any(one.resumes for one in there)):
            raise UserError(
                "--paused, --break and --approve wait for a person, but there is no terminal for "
                "keys; add --with page or --with foxglove"
            )

    @contextmanager
    def open(self) -> Iterator[None]:
        """Listen to keys, and print how to control the run; enter it once the viewer is up."""
        with keys(self.control) as listening:
            if listening:
                self._say(HELP)
            yield

    def show(self, snapshot: Snapshot) -> None:
        """Take a tick: tell of an emergency stop, and stand in for a person."""
        emergency = self.control.state.emergency
        if emergency and not self._emergency:
            self._say(
                f"{emergency}: the run is paused; release the button, acknowledge the stop "
                "(key a, or the page), then resume"
            )
        self._emergency = emergency
        if self._options.acknowledge_after is not None:
            self._stand_in(snapshot, self._options.acknowledge_after)

    def leave(self) -> None:
        """End the run and the page, as Ctrl-C does."""
        self.left = True
        self.control.stop()

    def _stand_in(self, snapshot: Snapshot, patience: float) -> None:
        """Acknowledge and resume as a person would, once the cause of the pause is over."""
        state = self.control.state
        over = not state.pressed and all(
            fault.clearable and fault.text not in state.why for fault in snapshot.state.faults
        )
        if not (state.paused and over):
            self._over_since = None
        elif self._over_since is None:
            self._over_since = snapshot.stamp
        elif snapshot.stamp - self._over_since >= patience:
            if state.emergency:
                self.control.acknowledge()
            else:
                self.control.resume()

    def _reached(self, hook: Hook) -> None:
        name = hook.name
        self.control.pause(f"{name} waits for approval" if hook.asks else f"before {name}")


def _moves(node: Behaviour) -> bool:
    return not node.children and bool(getattr(node, "moves", False))


def in_terminal(file: int) -> bool:
    """Whether keys pressed in a terminal arrive at this file descriptor."""
    try:
        return os.isatty(file) and os.tcgetpgrp(file) == os.getpgrp()
    except OSError:
        return False


@contextmanager
def keys(control: Control, file: int = 0) -> Iterator[bool]:
    """Listen to keys of a terminal within the context; yields whether they are heard.

    They are not without a terminal, or where no thread is left. The terminal's settings are
    restored at the end.
    """
    if not in_terminal(file):
        yield False
        return
    actions: dict[bytes, Callable[[], None]] = {
        b" ": control.pause,
        b"r": control.resume,
        b"s": control.step,
        b"n": control.run_to_next_change,
        b"q": control.stop,
        b"a": control.acknowledge,
    }
    before = termios.tcgetattr(file)
    end, ended = os.pipe()
    listener = None
    try:
        tty.setcbreak(file, termios.TCSADRAIN)
        with suppress(HardwareError):  # no thread can be started; Ctrl-C still ends the run
            listener = begun(_listen, "keys", file, end, actions)
        yield listener is not None
    finally:
        os.write(ended, b".")
        if listener is not None:
            listener.join()
        with suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(file, termios.TCSADRAIN, before)
        os.close(end)
        os.close(ended)


def _listen(file: int, end: int, actions: dict[bytes, Callable[[], None]]) -> None:
    with suppress(OSError):  # the terminal is gone
        while end not in select.select([file, end], [], [])[0]:
            pressed = os.read(file, 1)
            if not pressed:
                return
            if action := actions.get(pressed.lower()):
                action()
