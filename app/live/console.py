"""Operator console: combines keys, control page, breakpoints and Groot2 for one run."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from py_trees.behaviour import Behaviour

from app.live.changes import Moment, RunInfo
from app.live.groot import USUAL_PORT, GrootServer
from app.live.nodes import tree_view
from app.live.operator import (
    HELP,
    Control,
    ControlPage,
    Hook,
    PagePipe,
    PageServer,
    in_terminal,
    insert_hooks,
    keys,
    matching,
)
from app.live.plan import Plan
from app.live.snapshot import Snapshot, key_figures
from app.terminal import until_interrupted
from config import UserError
from trees.language import TreeNode


@dataclass(frozen=True, kw_only=True)
class ControlOptions:
    """Options of control."""

    page: bool = False
    remote: bool = False  # whether a viewer may resume
    page_port: int | None = None  # None takes the usual port, or a free one if that is taken
    pipe: int | None = None  # a socket to the process that serves the page instead, if any
    paused: bool = False
    breaks: tuple[str, ...] = ()
    groot: bool = False
    groot_port: int = USUAL_PORT
    force: bool = False
    approve: bool = False
    acknowledge_after: float | None = None
    """For unattended tests: acknowledge and resume this long after the cause is over [s]."""


class OperatorConsole:
    """Controls of one run; use it in a `with` statement. Invalid options raise before it moves.

    `inject` and `clear` inject a fault by name and clear the injected ones, `viewer` is the address
    of live data for a viewer on the page, `plan` draws the scene there, and `say` prints a line.
    `server` serves the page across several runs; None makes one for this run. Raises UserError: an
    option is wrong, or something cannot be served.
    """

    def __init__(
        self,
        options: ControlOptions,
        *,
        info: RunInfo,
        nodes: Sequence[TreeNode],
        inject: Callable[[str], None],
        clear: Callable[[], None],
        viewer: str | None,
        say: Callable[[str], None],
        plan: Plan | None = None,
    ) -> None:
        _check(options)
        self.control = Control(
            paused=options.paused,
            attended=options.page or in_terminal(0) or options.acknowledge_after is not None,
        )
        self.left = False
        self._acknowledge_after = options.acknowledge_after
        self._over_since: float | None = None
        self._say = say
        self._emergency = ""
        self._groot: GrootServer | None = None
        self._page: ControlPage | None = None
        self._server: PageServer | PagePipe | None = None
        tree = tree_view(nodes)
        self.root, hooks = self._insert(options, nodes)
        with ExitStack() as stack:
            if options.groot:
                groot = GrootServer(info.task, tree, hooks, self.control, port=options.groot_port)
                self._groot = stack.enter_context(groot)
            if options.page:
                self._server = stack.enter_context(_server(options))
                self._page = ControlPage(
                    self.control,
                    tree,
                    inject=inject,
                    clear=clear,
                    info=info,
                    plan=plan,
                    viewer=viewer,
                    hooks=hooks,
                    may_force=options.force,
                )
                self._server.serve(self._page)
            self._stack = stack.pop_all()

    def __enter__(self) -> OperatorConsole:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @contextmanager
    def open(self) -> Iterator[None]:
        """Listen to keys, and print how to control the run; enter it once the viewer is up."""
        with keys(self.control) as listening:
            if listening:
                self._say(HELP)
            if isinstance(self._server, PageServer):
                self._say(f"control at {self._server.url}")
            yield

    def show(self, moment: Moment, *, changed: bool) -> None:
        """Pass a tick to the page and to Groot2; `changed` is whether a node's status changed."""
        snapshot = moment.seen
        emergency = self.control.state.emergency
        if emergency and not self._emergency:
            self._say(
                f"{emergency}: the run is paused; release the button, acknowledge the stop "
                "(key a, or the page), then resume"
            )
        self._emergency = emergency
        if self._acknowledge_after is not None:
            self._stand_in(snapshot, self._acknowledge_after)
        if self._page is not None:
            self._page.show(moment, changed=changed)
        if self._groot is not None:
            self._groot.show(snapshot, {**snapshot.blackboard, **key_figures(snapshot)})

    def leave(self) -> None:
        """End the run and the page, as Ctrl-C does."""
        self.left = True
        self.control.stop()

    def finish(self) -> None:
        """Report that the loop has ended and the robot is at rest."""
        if self._page is not None:
            self._page.finish()

    def stay(self, outcome: str, explanation: str) -> None:
        """Show on the page how the run ended, and keep it until Ctrl-C.

        Returns at once if another process serves the page, or after Ctrl-C in the run.
        """
        if self._page is None:
            return
        self._page.end(outcome, explanation)
        if not isinstance(self._server, PageServer):
            return
        if self.left:
            self._server.farewell()
            return
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            with until_interrupted():
                self._say(f"the page stays at {self._server.url}; Ctrl-C ends it")
        finally:
            signal.signal(signal.SIGTERM, before)

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

    def _insert(
        self, options: ControlOptions, nodes: Sequence[TreeNode]
    ) -> tuple[Behaviour, list[Hook]]:
        stops = {node for wanted in options.breaks for node in matching(nodes, wanted)}
        every = [node.node for node in nodes]
        asks = {node for node in every if options.approve and _moves(node)}
        everywhere = options.groot or options.page
        hooked = every if everywhere else [one for one in every if one in stops | asks]
        root, hooks = insert_hooks(nodes[0].node, hooked, self._reached)
        for hook in hooks:
            hook.asks, hook.stops = hook.node in asks, hook.node in stops
        return root, hooks

    def _reached(self, hook: Hook) -> None:
        name = hook.name
        self.control.pause(f"{name} waits for approval" if hook.asks else f"before {name}")
        if self._groot is not None:
            self._groot.reached(hook)


@contextmanager
def _server(options: ControlOptions) -> Iterator[PageServer | PagePipe]:
    pipe = options.pipe
    with PageServer(options.page_port) if pipe is None else PagePipe(pipe) as pages:
        yield pages


def _check(options: ControlOptions) -> None:
    """Raise UserError for a run that would pause and that nobody could resume."""
    has_person = options.page or options.groot or options.remote or in_terminal(0)
    if (options.paused or options.breaks or options.approve) and not has_person:
        raise UserError(
            "--paused, --break and --approve wait for a person, but there is no terminal for "
            "keys; add --control, --groot2 or --view foxglove"
        )
    if options.force and not options.page:
        raise UserError("--force-outcomes is for the page; add --control")


def _moves(node: Behaviour) -> bool:
    return not node.children and bool(getattr(node, "moves", False))
