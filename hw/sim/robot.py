"""The simulated robot: kinematics with lag, a hand that touches things, a camera that sees them."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Command, RobotModel
from hw.clock import Clock
from hw.interfaces import HAND_OPENING, DepthFrame, Fault, FaultKind, RobotState
from hw.sim.hand import Hand
from hw.sim.noise import D435Noise
from hw.sim.render import DepthRenderer
from hw.sim.world import World


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """How the simulated robot answers to commands."""

    period: float = 0.01
    """A command holds for one period [s]; without a new one the robot stops."""
    arm_lag: float = 0.03
    """Time constant of the joints [s]."""
    base_lag: float = 0.10
    """Time constant of the base [s]."""
    finger_speed: float = 0.1
    """Change of the opening when the fingers move [m/s]."""
    slip_distance: float = 0.005
    """Fingers that press on a thing without holding it slip off when the hand moves so far [m]."""
    frame_rate: float = 30.0
    """Camera frames a second [Hz]."""
    battery_life: float = 4.0 * 3600.0
    """Time in which a full battery runs down, whatever the robot does [s]."""


class SimRobot:
    """A robot made of numbers: everything it does is a function of world, commands and seed.

    It lives on the injected clock: a reading integrates what was commanded up to now.

    Args:
        model: which robot; not to be shared with another thread.
        world: what is around it.
        clock: simulated time.
        seed: of the camera's noise.
        dynamics: how it answers.
        noise: of the camera; None for a perfect one.
    """

    def __init__(
        self,
        model: RobotModel,
        world: World,
        clock: Clock,
        seed: int = 0,
        dynamics: Dynamics | None = None,
        noise: D435Noise | None = None,
    ) -> None:
        self.world = world
        self._model = model
        self._clock = clock
        self._seed = seed
        self._dynamics = dynamics or Dynamics()
        self._noise = noise or D435Noise()
        self._camera = model.description.camera
        self._renderer = DepthRenderer(self._camera.intrinsics)
        self._now = clock.now()
        self._valid_until = self._now
        self._command = Command.stop()
        self._wTb = SE3.Identity()
        self._base_twist = np.zeros(3)
        self._q = model.description.arm.ready.copy()
        self._qd = np.zeros(7)
        self._width = HAND_OPENING
        self._width_goal = HAND_OPENING
        self._fingers_move = False
        self._pressing_from: SE3 | None = None
        self._wanted_width = HAND_OPENING
        self._slipping = False
        self._reflex: str | None = None
        self._forgiven: str | None = None
        self._last_frame = -1

    def connect(self) -> None:
        """Nothing to reach: the simulated robot is always there."""

    def close(self) -> None:
        """Stop."""
        self.stop()

    def read(self) -> RobotState:
        """The reading at this moment of simulated time."""
        self._advance()
        faults = (
            (Fault(kind=FaultKind.REFLEX, text=f"the hand hit {self._reflex}", clearable=True),)
            if self._reflex
            else ()
        )
        return RobotState(
            stamp=self._now,
            wTb=self._wTb,
            base_twist=self._base_twist,
            q=self._q,
            qd=self._qd,
            gripper_width=self._width,
            gripper_moving=self._fingers_move,
            faults=faults,
            battery=max(0.0, 1.0 - self._now / self._dynamics.battery_life),
        )

    def send(self, command: Command) -> Command:
        """Follow a command for one period; with a reflex the arm stays where it is."""
        self._advance()
        if self._reflex:
            command = Command(base_twist=command.base_twist, qd=np.zeros(7))
        self._command = command
        self._valid_until = self._now + self._dynamics.period
        return command

    def stop(self) -> None:
        """Forget the command: the robot comes to rest with its lag."""
        self._command = Command.stop()

    def recover(self) -> None:
        """Clear a reflex; the thing that was hit is forgiven until the hand has left it."""
        self._forgiven, self._reflex = self._reflex, None

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to a width [m]; closing stops at what the contacts decide.

        The contacts are decided on the pose of the hand when closing starts. Fingers that press on
        something without holding it close the rest of the way when the hand moves off.
        """
        self._advance()
        if width > self._width:
            self.world.open_fingers()
            self._width_goal = min(width, HAND_OPENING)
            self._pressing_from = None
        else:
            wTe = self._wTe()
            outcome = self.world.close_fingers(self._hand(), self._width, force, width)
            self._width_goal = outcome.width
            if outcome.holding is None:
                self._pressing_from, self._wanted_width = wTe, width
        self._slipping = False
        self._fingers_move = self._width != self._width_goal

    def depth(self) -> DepthFrame | None:
        """The newest frame of the camera, rendered when it is asked for."""
        self._advance()
        frame = int(self._now * self._dynamics.frame_rate + 1e-9)
        if frame == self._last_frame:
            return None
        self._last_frame = frame
        wTe = self._wTe()
        wTc = wTe * self._camera.eTc
        shapes = [*self.world.shapes(), *self._hand().shapes(self._width)]
        # One generator a frame: it looks the same whether or not those before were asked for.
        rng = np.random.default_rng((self._seed, frame))
        depth = self._noise.apply(self._renderer.render(shapes, wTc), self._camera, rng)
        return DepthFrame(depth=depth, intrinsics=self._camera.intrinsics, wTc=wTc, stamp=self._now)

    def _hand(self) -> Hand:
        return Hand(self._model.description.gripper, self._wTe())

    def _wTe(self) -> SE3:
        return self._model.wTe(self._wTb, self._q)

    def _advance(self) -> None:
        """Integrate up to the clock's time, a period at a time."""
        now = self._clock.now()
        while self._now < now - 1e-9:
            dt = min(self._dynamics.period, now - self._now)
            command = self._command if self._now < self._valid_until - 1e-9 else Command.stop()
            self.world.move_to(self._now + dt)
            self._integrate(command, dt)
            self._now += dt
        self._now = now

    def _integrate(self, command: Command, dt: float) -> None:
        """First-order lag on every axis, then exact motion along the arc that it gives."""
        d = self._dynamics
        self._base_twist = self._base_twist + (1.0 - exp(-dt / d.base_lag)) * (
            command.base_twist - self._base_twist
        )
        vx, vy, w = self._base_twist * dt
        self._wTb = self._wTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        if self._reflex:
            self._qd = np.zeros(7)
        else:
            self._qd = self._qd + (1.0 - exp(-dt / d.arm_lag)) * (command.qd - self._qd)
            self._q = self._q + self._qd * dt
        self._move_fingers(d.finger_speed * dt)
        self._touch()

    def _move_fingers(self, step: float) -> None:
        """A step towards the width that is wanted; slipping fingers slide along what is between."""
        width = self._width + float(np.clip(self._width_goal - self._width, -step, step))
        if self._slipping and self.world.collision(self._hand(), width):
            width = self._width
        self._fingers_move = width != self._width
        self._width = width

    def _touch(self) -> None:
        """Carry what is held, slip off what is not, trip the reflex if the hand hits something."""
        wTe = self._wTe()
        self.world.carry(wTe)
        if self._pressing_from is not None:
            moved = np.linalg.norm(wTe.translation - self._pressing_from.translation)
            if moved > self._dynamics.slip_distance:
                self._slipping, self._pressing_from = True, None
                self._width_goal = self._wanted_width
        hit = self.world.collision(self._hand(), self._width)
        if hit is None:
            self._forgiven = None
        elif hit != self._forgiven:
            self._reflex = hit
            self._qd = np.zeros(7)
