"""Everything that a person can have in hand during a run: keys, page, breakpoints, Groot2."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from py_trees.behaviour import Behaviour

from app.core.events import values
from app.core.setup import Setup
from app.core.snapshots import tree_view
from app.live.groot import USUAL_PORT, GrootError, GrootServer
from app.live.monitor import Snapshot
from app.live.operator import Act, Control, Hook, Side, insert_hooks, keys, matching
from app.live.operator.keyboard import HELP, in_terminal
from app.live.operator.page import ControlPage, PageError, WebViewer
from config import UserError
from trees.language import TreeNode

__all__ = ["ControlOptions", "GrootError", "NoControlError", "OperatorConsole", "PageError"]


class NoControlError(UserError):
    """The run would pause and nobody could let it go on."""


@dataclass(frozen=True, kw_only=True)
class ControlOptions:
    """What a person may choose about control."""

    page: bool = False
    """Serve the page."""
    page_port: int | None = None
    """None takes the usual one, or any free one if that is taken."""
    paused: bool = False
    """Wait for a person before the first tick."""
    breaks: tuple[str, ...] = ()
    """Nodes before which the run pauses, by name, key or path."""
    groot: bool = False
    """Serve Groot2."""
    groot_port: int = USUAL_PORT


class OperatorConsole:
    """What people hold of one run; use it in a `with` statement.

    Everything that can be wrong with the options is found out here, before anything moves.

    Args:
        options: what a person chose.
        task: name of the task.
        nodes: the nodes of the tree, in preorder.
        setup: what the session works with.
        viewer: the web viewer to show on the page, if there is one.
        say: told what a person needs to know, a line at a time.

    Raises:
        UnknownNodeError: a breakpoint is before no node of the tree.
        NoControlError: the run would pause, and there are neither keys nor page nor Groot2.
        PageError: the page cannot be served.
        GrootError: Groot2 cannot be served.
    """

    def __init__(
        self,
        options: ControlOptions,
        *,
        task: str,
        nodes: Sequence[TreeNode],
        setup: Setup,
        viewer: WebViewer | None,
        say: Callable[[str], None],
    ) -> None:
        self.control = Control(paused=options.paused)
        self._rig = setup
        self._say = say
        self._groot: GrootServer | None = None
        self._page: ControlPage | None = None
        self._mended = False
        self._stack = ExitStack()
        if (options.paused or options.breaks) and not (
            options.page or options.groot or in_terminal(0)
        ):
            raise NoControlError(
                "--paused and --break wait for a person, and there is no terminal to press keys "
                "in; add --control or --groot2"
            )
        tree = tree_view(nodes)
        self.root, hooks = self._insert(options, nodes)
        try:
            if options.groot:
                self._groot = self._stack.enter_context(
                    GrootServer(task, tree, hooks, self.control, port=options.groot_port)
                )
            if options.page:
                self._page = self._stack.enter_context(
                    ControlPage(
                        self.control,
                        tree,
                        inject=setup.robot.inject,
                        clear=self.clear,
                        viewer=viewer,
                        port=options.page_port,
                    )
                )
        except (GrootError, PageError):
            self._stack.close()
            raise

    def __enter__(self) -> OperatorConsole:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @contextmanager
    def open(self) -> Iterator[None]:
        """Tell people what they hold, and listen to keys; when the viewer is up that they see."""
        with keys(self.control) as listening:
            if listening:
                self._say(HELP)
            if self._page is not None:
                self._say(f"control at {self._page.url}")
            yield

    def show(self, seen: Snapshot, *, changed: bool) -> None:
        """Tell everybody what a tick looked like.

        Args:
            seen: the tick.
            changed: whether some node changed its status.
        """
        if changed:
            self.control.node_changed()
        if self._page is not None:
            self._page.show(seen)
        if self._groot is not None:
            self._groot.show(seen, {**seen.blackboard, **values(seen)})
        if self._mended and not seen.state.faults:
            self._mended = False
            self._rig.gate.release()

    def _insert(
        self, options: ControlOptions, nodes: Sequence[TreeNode]
    ) -> tuple[Behaviour, list[Hook]]:
        """Hooks before the nodes of the breakpoints, and for Groot2 before all."""
        stops = {node for wanted in options.breaks for node in matching(nodes, wanted)}
        everywhere = [place.node for place in nodes]
        hooked = everywhere if options.groot else [node for node in everywhere if node in stops]
        root, hooks = insert_hooks(nodes[0].node, hooked, self._reached)
        for hook in hooks:
            if hook.node in stops:
                hook.acts = {Side.BEFORE: Act()}
        return root, hooks

    def _reached(self, hook: Hook, side: Side, act: Act) -> None:
        if act.instead is None:
            self.control.pause(f"{side.name.lower()} {hook.name}")
        if self._groot is not None:
            self._groot.reached(hook, side)

    def clear(self) -> None:
        """Take injected faults away; the gate opens again on the loop, with the next reading."""
        self._rig.robot.clear()
        self._mended = True
