"""Runs one leaf on a simulated robot, for tests of a behaviour."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core import End, Session, Setup, Tick, open_setup
from app.live import Control
from app.run_options import RunOptions
from behaviours import Context
from config import UserError
from hw import Truth
from perception import GraspDetector
from robots import load_robot


class BrokenTrialError(AssertionError):
    """A leaf crashed, or the robot failed, in a trial."""


class Trial:
    """A robot in a scene, with controller, gate and clock."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup

    @property
    def context(self) -> Context:
        """The context to construct a leaf with."""
        return self._setup.context

    @property
    def world(self) -> Truth:
        """True state of the scene."""
        assert self._setup.truth is not None
        return self._setup.truth

    def now(self) -> float:
        """Simulated time [s]."""
        return self._setup.clock.session.now()

    def inject(self, fault: str) -> None:
        """Inject a fault, as `reflex`; UserError: there is none such, or none in this world."""
        if (injector := self._setup.injector) is None:
            raise UserError("no fault can be injected here; say `world='faulty'`")
        injector.inject(fault)

    def run(self, leaf: Behaviour, seconds: float = 60.0) -> Status:
        """Tick a leaf made with `context`, or a tree, until it ends; bring the robot to rest.

        Returns SUCCESS or FAILURE; RUNNING if it was halted after `seconds` of simulated time.
        Raises BrokenTrialError: it has crashed, or the robot has failed.
        """
        setup, control, end = self._setup, Control(attended=False), self.now() + seconds

        def stop_in_time(_tick: Tick) -> None:
            if self.now() >= end:
                control.stop()

        outcome = Session(setup, leaf, control, stop_in_time).run()
        statuses = {
            End.SUCCESS: Status.SUCCESS,
            End.FAILURE: Status.FAILURE,
            End.INTERRUPTED: Status.RUNNING,
        }
        if outcome.end not in statuses:
            raise BrokenTrialError(f"{outcome.end.value}: {outcome.reason}\n{outcome.trace}")
        return statuses[outcome.end]


@contextmanager
def trial(
    scene: str | Path = "single",
    *,
    robot: str = "frankie",
    world: str = "kinematic",
    seed: int = 0,
) -> Iterator[Trial]:
    """A simulated robot in a scene; raises UserError if there is no such one, robot or world."""
    detector = GraspDetector.shipped(load_robot(robot).gripper)
    options = RunOptions(
        tree=Path(),
        robot=robot,
        world=world,
        scene=str(scene),
        seed=seed,
        localisation="exact",
    )
    with open_setup(options, detector) as setup:
        yield Trial(setup)
