"""Simulated robot: arm, base, gripper, camera and laser as views of one body."""

from concurrent.futures import Executor, Future
from functools import partial
from math import atan2
from typing import Any

import numpy as np
from pinocchio import SE3

from hw.clock import Clock
from hw.composition import ComposedRobot, InlineExecutor
from hw.robot import PassivePart
from hw.sim.body import Dynamics, Reflex, SimBody
from hw.sim.camera.noise import D435Noise
from hw.sim.camera.render import DepthRenderer, painted
from hw.sim.kinematic import KinematicBody
from hw.sim.levels import Localisation
from hw.sim.localisation_errors import LocalisationProcess, made_wrong
from hw.sim.sim_laser import SimLaser
from hw.sim.sim_object import Visible
from hw.sim.sim_world import World
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
from hw.truth import Truth
from robots import KINDS, RobotDescription


class SimPart(PassivePart):
    """A part of a body."""

    def __init__(self, body: SimBody) -> None:
        self.body = body

    @property
    def truth(self) -> Truth | None:
        """What is true of its world."""
        return self.body.truth

    def stop(self) -> None:
        """The body comes to rest with its lag."""
        self.body.stop()

    def close(self) -> None:
        """Stop."""
        self.stop()

    def _faults(self, kind: FaultKind, reflex: Reflex) -> tuple[Fault, ...]:
        """The fault of a stopped part; for the base with its bearing."""
        if reflex.reason is None:
            return ()
        x, y, _ = (self.body.wTb.rotation.T @ reflex.towards).tolist()
        told = kind is FaultKind.BUMPER and (x, y) != (0.0, 0.0)
        bearing = round(atan2(y, x), 1) if told else None  # as coarse as the parts of a bumper
        return (Fault(kind=kind, text=reflex.reason, clearable=True, bearing=bearing),)


class _SimArm(SimPart):
    def read(self) -> ArmState:
        body = self.body
        body.advance()
        faults = self._faults(FaultKind.REFLEX, body.reflex)
        return ArmState(stamp=body.now, q=body.q, qd=body.qd, faults=faults)

    def send(self, qd: Array) -> Array:
        self.body.advance()
        applied = qd if self.body.reflex.reason is None else np.zeros(len(qd))
        self.body.follow(qd=applied)
        return applied

    def recover(self) -> None:
        self.body.reflex.clear()


class _SimBase(SimPart):
    def __init__(self, body: SimBody, localisation: LocalisationProcess) -> None:
        super().__init__(body)
        self._localisation = localisation

    def read(self) -> BaseState:
        body = self.body
        body.advance()
        oTb, localised = self._localisation.read(body.now, body.wTb)
        return BaseState(
            stamp=body.now,
            oTb=oTb,
            twist=body.base_twist,
            battery=max(0.0, 1.0 - body.now / body.dynamics.battery_life),
            faults=self._faults(FaultKind.BUMPER, body.bumper),
            localised=localised,
        )

    def send(self, twist: Array) -> Array:
        self.body.advance()
        applied = twist if self.body.bumper.reason is None else np.zeros(3)
        self.body.follow(base_twist=applied)
        return applied

    def recover(self) -> None:
        self.body.bumper.clear()


class _SimGripper(SimPart):
    def read(self) -> GripperState:
        body = self.body
        body.advance()
        return GripperState(stamp=body.now, width=body.width, moving=body.fingers_move)

    def grip(self, width: float, force: float) -> None:
        """Start moving the fingers."""
        self.body.grip(width, force)


class _SimCamera(SimPart):
    """The depth camera: one image a frame period, at once, or later if rendered beside the loop."""

    def __init__(
        self, body: SimBody, noise: D435Noise, seed: int, executor: Executor, scale: float = 1.0
    ) -> None:
        super().__init__(body)
        self._scale = np.float32(scale)
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
        body = self.body
        body.advance()
        number = int(body.now * self._camera.rate + 1e-9)
        # Who gets an image may have no use for another one.
        if not self._collect() and self._pending is None and number != self._number:
            self._number = number
            wTc = body.wTe * self._camera.eTc
            self._pending = self._executor.submit(
                self._capture, body.shapes(), wTc, number, body.now
            )
            self._collect()
        return self._image

    def faults(self) -> tuple[Fault, ...]:
        """None."""
        return ()

    def close(self) -> None:
        """Stop rendering."""
        super().close()
        self._executor.shutdown(wait=False, cancel_futures=True)

    def _collect(self) -> bool:
        """Take the image that was begun; whether it is ready."""
        if self._pending is None or not self._pending.done():
            return False
        self._image, self._pending = self._pending.result(), None
        return True

    def _capture(self, shapes: list[Visible], wTc: SE3, number: int, stamp: float) -> DepthImage:
        # One generator a frame, so that it does not depend on earlier frames.
        rng = np.random.default_rng((self._seed, number))
        depth = self._renderer.render(shapes, wTc)
        noisy = self._noise.apply(depth, self._camera, rng)

        def paint() -> ColourArray:
            return painted(shapes, self._renderer.render_with_ids(shapes, wTc)[1])

        return DepthImage(depth=noisy * self._scale, stamp=stamp, paint=paint)


def simulated_robot(
    body: type[SimBody],
    description: RobotDescription,
    world: World,
    clock: Clock,
    *,
    seed: int = 0,
    dynamics: Dynamics | None = None,
    noise: D435Noise | None = None,
    localisation: Localisation | None = None,
    rendering: Executor | None = None,
) -> ComposedRobot:
    """A robot of one simulated body; `rendering` is where images are rendered."""
    truly, process, scale = made_wrong(description, localisation or Localisation(), seed)
    made = body(truly, world, clock, dynamics or Dynamics(), process)
    make = partial(part_of, made, seed=seed, noise=noise, rendering=rendering, depth_scale=scale)
    parts = {kind: make(kind) for kind in KINDS if kind != "laser" or description.laser}
    return ComposedRobot(description, **parts, clock=clock, background=InlineExecutor)


def part_of(
    body: SimBody,
    kind: str,
    *,
    seed: int,
    noise: D435Noise | None = None,
    rendering: Executor | None = None,
    depth_scale: float = 1.0,
) -> Any:
    """A part of a body, by its kind."""
    match kind:
        case "arm":
            return _SimArm(body)
        case "base":
            return _SimBase(body, body.wheels)
        case "gripper":
            return _SimGripper(body)
        case "camera":
            rendering = rendering or InlineExecutor()
            return _SimCamera(body, noise or D435Noise(), seed, rendering, depth_scale)
    assert body.description.laser is not None
    return SimLaser(body, body.description.laser, seed)


kinematic_robot = partial(simulated_robot, KinematicBody)  # a function of its seed
