"""The parts of the simulated robot: views of one body, composed as those of any other robot."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from math import atan2

import numpy as np
from pinocchio import SE3

from hw.background import InlineExecutor
from hw.clock import Clock
from hw.composition import ComposedRobot
from hw.sim.body import Dynamics, SimBody, Stopper
from hw.sim.kinematic import KinematicBody
from hw.sim.noise import D435Noise
from hw.sim.render import DepthRenderer, painted
from hw.sim.surface import Visible
from hw.sim.world import World
from hw.state import (
    ArmState,
    Array,
    BaseState,
    ColourArray,
    DepthImage,
    Fault,
    FaultKind,
    GripperState,
)
from robots import RobotDescription


class _SimPart:
    """What the parts have in common: they are always there, and stop with the body."""

    def __init__(self, body: SimBody) -> None:
        self._body = body

    def connect(self) -> None:
        """Nothing to reach."""

    def stop(self) -> None:
        """The body comes to rest with its lag."""
        self._body.stop()

    def close(self) -> None:
        """Stop."""
        self.stop()

    def _faults(self, kind: FaultKind, stopper: Stopper) -> tuple[Fault, ...]:
        """That a part was stopped, and on what; of the base, on which side."""
        if stopper.reason is None:
            return ()
        x, y, _ = (self._body.wTb.rotation.T @ stopper.towards).tolist()
        told = kind is FaultKind.BUMPER and (x, y) != (0.0, 0.0)
        bearing = round(atan2(y, x), 1) if told else None  # as coarse as the parts of a bumper
        return (Fault(kind=kind, text=stopper.reason, clearable=True, bearing=bearing),)


class SimArm(_SimPart):
    """The arm; with a reflex it stays where it is."""

    def read(self) -> ArmState:
        """The reading at this moment of simulated time."""
        body = self._body
        body.advance()
        faults = self._faults(FaultKind.REFLEX, body.reflex)
        return ArmState(stamp=body.now, q=body.q, qd=body.qd, faults=faults)

    def send(self, qd: Array) -> Array:
        """Follow joint velocities for one period."""
        self._body.advance()
        applied = qd if self._body.reflex.reason is None else np.zeros(7)
        self._body.follow(qd=applied)
        return applied

    def recover(self) -> None:
        """Clear a reflex, at once."""
        self._body.reflex.clear()


class SimBase(_SimPart):
    """The base; with its bumper pressed it stands still."""

    def read(self) -> BaseState:
        """The reading at this moment of simulated time."""
        body = self._body
        body.advance()
        battery = max(0.0, 1.0 - body.now / body.dynamics.battery_life)
        return BaseState(
            stamp=body.now,
            wTb=body.wTb,
            twist=body.base_twist,
            battery=battery,
            faults=self._faults(FaultKind.BUMPER, body.bumper),
        )

    def send(self, twist: Array) -> Array:
        """Follow a twist for one period."""
        self._body.advance()
        applied = twist if self._body.bumper.reason is None else np.zeros(3)
        self._body.follow(base_twist=applied)
        return applied

    def recover(self) -> None:
        """Clear the bumper, at once."""
        self._body.bumper.clear()


class SimGripper(_SimPart):
    """The gripper."""

    def read(self) -> GripperState:
        """The reading at this moment of simulated time."""
        body = self._body
        body.advance()
        return GripperState(stamp=body.now, width=body.width, moving=body.fingers_move)

    def grip(self, width: float, force: float) -> None:
        """Set the fingers moving."""
        self._body.grip(width, force)

    def recover(self) -> None:
        """It has no faults."""


class SimCamera(_SimPart):
    """The depth camera: an image is captured when it is asked for, at most one a frame period.

    Rendered inline, the image is there at once. Rendered beside the loop it comes later, with the
    stamp of its capture, and what is asked for meanwhile is the one before: as a real camera does.

    Args:
        body: whose camera.
        noise: of the camera.
        seed: of the noise.
        executor: where images are rendered.
    """

    def __init__(self, body: SimBody, noise: D435Noise, seed: int, executor: Executor) -> None:
        super().__init__(body)
        self._camera = body.description.camera
        self._renderer = DepthRenderer(self._camera.intrinsics)
        self._noise = noise
        self._seed = seed
        self._executor = executor
        self._number = -1
        self._image: DepthImage | None = None
        self._pending: Future[DepthImage] | None = None

    def latest(self) -> DepthImage | None:
        """The newest image that is ready."""
        body = self._body
        body.advance()
        number = int(body.now * self._camera.rate + 1e-9)
        if self._pending is None and number != self._number:
            self._number = number
            wTc = body.wTe * self._camera.eTc
            self._pending = self._executor.submit(
                self._capture, body.shapes(), wTc, number, body.now
            )
        if self._pending is not None and self._pending.done():
            self._image, self._pending = self._pending.result(), None
        return self._image

    def faults(self) -> tuple[Fault, ...]:
        """None: it is always there."""
        return ()

    def recover(self) -> None:
        """Nothing to do."""

    def close(self) -> None:
        """Stop, and render no more."""
        super().close()
        self._executor.shutdown(wait=False, cancel_futures=True)

    def _capture(self, shapes: list[Visible], wTc: SE3, number: int, stamp: float) -> DepthImage:
        # One generator a frame: it looks the same whether or not those before were asked for.
        rng = np.random.default_rng((self._seed, number))
        depth = self._renderer.render(shapes, wTc)
        noisy = self._noise.apply(depth, self._camera, rng)

        def paint() -> ColourArray:
            return painted(shapes, self._renderer.render(shapes, wTc, with_ids=True)[1])

        return DepthImage(depth=noisy, stamp=stamp, paint=paint)


def simulated_robot(
    body: type[SimBody],
    description: RobotDescription,
    world: World,
    clock: Clock,
    *,
    seed: int = 0,
    dynamics: Dynamics | None = None,
    noise: D435Noise | None = None,
    background: Callable[[], Executor] = InlineExecutor,
) -> ComposedRobot:
    """A robot out of the parts of one simulated body.

    Args:
        body: what moves them.
        description: which robot.
        world: what is around it; what is held, and where everything is, is kept up to date in it.
        clock: simulated time.
        seed: of the camera's noise.
        dynamics: how it answers; None for the usual way.
        noise: of the camera; None for that of a D435.
        background: where images are rendered and what takes time is done; inline, a run is
            the same every time.
    """
    made = body(description, world, clock, dynamics or Dynamics())
    return ComposedRobot(
        description,
        arm=SimArm(made),
        base=SimBase(made),
        gripper=SimGripper(made),
        camera=SimCamera(made, noise or D435Noise(), seed, background()),
        clock=clock,
        background=background,
    )


kinematic_robot = partial(simulated_robot, KinematicBody)
"""A robot made of numbers: everything it does is a function of world, commands and seed."""
