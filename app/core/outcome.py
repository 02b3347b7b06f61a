"""Outcome of a run: how it ended, its exit code, and how exceptions are classified."""

from dataclasses import dataclass, field
from enum import Enum
from traceback import format_exception

from py_trees.behaviour import Behaviour

from behaviours import Context, LeafCrashedError
from controller import GoalError
from hw import HardwareError, LoopBlockedError
from trees.language import Branch


class End(Enum):
    """The ways a run can end."""

    SUCCESS = "success"
    FAILURE = "failure"  # the tree failed
    CRASH = "crash"  # a node, or the controller, raised an exception or blocked the loop
    HARDWARE = "hardware fault"  # the robot could not be read, commanded or believed any more
    INTERRUPTED = "interrupted"

    @property
    def exit_code(self) -> int:
        """Exit code of the process."""
        codes = {"success": 0, "failure": 1, "hardware fault": 3, "crash": 4, "interrupted": 130}
        return codes[self.value]


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended and why."""

    end: End
    reason: str  # what was achieved or what went wrong, for people
    node: str = ""  # the node that failed or crashed; empty if none did
    where: Behaviour | None = field(default=None, compare=False)
    """The node that `node` names, or the one that ran; None if unknown."""
    trace: str = ""  # traceback of a crash of a leaf or the controller; else empty


class Stage(Enum):
    """Step of the loop that is executing."""

    READ = "reading the robot"
    TREE = "the tree"
    CONTROL = "the controller"
    SEND = "commanding the robot"
    WATCH = "those who watch the run"

    @property
    def is_hardware(self) -> bool:
        """Whether an exception here is a fault of the hardware."""
        return self in (Stage.READ, Stage.SEND)


def outcome_of(
    error: BaseException, stage: Stage, root: Behaviour, context: Context, too_slow: str = ""
) -> Outcome:
    """The outcome of a run in which `error` was raised during `stage`.

    `too_slow` says that the computer has not kept real time: what did not return is no mistake of
    the code then.
    """
    leaf = last_ticked(root)
    if isinstance(error, KeyboardInterrupt):
        return Outcome(end=End.INTERRUPTED, reason="told to stop", where=leaf)
    if isinstance(error, HardwareError):
        return Outcome(end=End.HARDWARE, reason=str(error), where=leaf)
    if isinstance(error, LoopBlockedError):
        if too_slow:
            why = f"{too_slow}, and `{leaf.name}` did not return in time"
            return Outcome(end=End.HARDWARE, reason=why, where=leaf)
        error = TimeoutError("did not return in time")
    elif isinstance(error, LeafCrashedError) and error.__cause__ is not None:
        error = error.__cause__
    text = str(error) if isinstance(error, GoalError) else f"{type(error).__name__}: {error}"
    if stage.is_hardware:
        return Outcome(end=End.HARDWARE, reason=f"{stage.value}: {text}", where=leaf)
    if stage is Stage.CONTROL:
        leaf = context.now.intent.owner if context.now.intent else leaf
        text = text if isinstance(error, GoalError) else f"{stage.value}: {text}"
    trace = "".join(format_exception(error))
    return Outcome(end=End.CRASH, reason=text, node=leaf.name, where=leaf, trace=trace)


def last_ticked(root: Behaviour) -> Behaviour:
    """The leaf that was ticked last, or was being ticked when an exception came."""
    node = root
    while isinstance(node, Branch) and node.current_child is not None:
        node = node.current_child
    return node
