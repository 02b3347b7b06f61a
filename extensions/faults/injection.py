"""A robot with injected faults, the table of those faults, and the world `faulty`."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from types import MappingProxyType

import numpy as np

from config import UserError, suggest
from controller import Command
from extensions.faults.effects import ROBOT_FAULTS, Effect, Injectable, Site
from extensions.faults.localisation_faults import LOCALISATION_FAULTS
from extensions.faults.world_faults import WORLD_FAULTS
from hw import (
    Backend,
    Camera,
    DepthFrame,
    DisturbableWorld,
    Robot,
    RobotState,
    RobotWrapper,
    Truth,
    WorldOptions,
    open_backend,
)

_STREAM = 30  # of random numbers, apart from those of the world

INJECTABLE: Mapping[str, Injectable] = MappingProxyType(
    {row.name: row for row in (*ROBOT_FAULTS, *LOCALISATION_FAULTS, *WORLD_FAULTS)}
)
"""The faults that can be injected, by name."""


@dataclass(eq=False)
class _Injected:
    effect: Effect
    duration: float  # [s]
    until: float = inf  # known once it has begun [s]


class FaultInjection(RobotWrapper):
    """A robot that has injected faults from the next reading on: a function of seed and calls."""

    def __init__(self, robot: Robot, truth: Truth | None = None, seed: int = 0) -> None:
        super().__init__(robot)
        self._world = truth if isinstance(truth, DisturbableWorld) else None
        self._rng = np.random.default_rng((seed, _STREAM))
        self._site: Site | None = None
        self._homes = {one.name: one.pose for one in self._world.objects} if self._world else {}
        self._lock = threading.Lock()
        self._wanted: dict[str, _Injected] = {}  # by name; changed by any thread
        self._effects: dict[str, Effect] = {}  # begun and not ended; changed by `read` alone

    @property
    def names(self) -> tuple[str, ...]:
        """See `Injector`; objects are disturbed in a simulated world alone."""
        here = self._world is not None
        return tuple(name for name, one in INJECTABLE.items() if here or not one.of_world)

    def inject(self, name: str, duration: float = inf) -> None:
        """See `Injector`."""
        if name not in self.names:
            raise UserError(f"no fault is called `{name}` here; {suggest(name, self.names)}")
        with self._lock:
            self._wanted[name] = _Injected(INJECTABLE[name].make(), duration)

    def clear(self, name: str | None = None) -> None:
        """See `Injector`."""
        with self._lock:
            self._wanted = {n: e for n, e in self._wanted.items() if name not in (None, n)}

    @property
    def camera(self) -> Camera:
        """The camera of the robot, with the faults."""
        return Camera(self._latest)

    def read(self) -> RobotState:
        """The reading of the robot, with the faults."""
        state = self._robot.read()
        if self._wanted or self._effects:
            self._update(state)
            for effect in self._effects.values():
                state = effect.reading(state)
        return state

    def send(self, command: Command) -> Command:
        """What the robot applied, or claims to have applied."""
        wanted = command
        for effect in self._effects.values():
            wanted = effect.command(wanted)
        applied = self._robot.send(wanted)
        if wanted is command:
            return applied
        return Command(base_twist=command.base_twist, qd=applied.qd)

    def grip(self, width: float, force: float) -> None:
        """See `Robot`; the faults may change it."""
        for effect in self._effects.values():
            if (reached := effect.grip(width)) is None:
                return
            width = reached
        self._robot.grip(width, force)

    def recover(self) -> None:
        """See `Robot`; also clears the injected faults that a program may clear."""
        super().recover()
        for effect in self._effects.values():
            effect.recovered()
        with self._lock:
            self._wanted = {n: e for n, e in self._wanted.items() if not INJECTABLE[n].clearable}

    def _update(self, state: RobotState) -> None:
        """Begin and end faults that were injected and cleared since the last reading."""
        with self._lock:
            self._wanted = {n: i for n, i in self._wanted.items() if state.stamp < i.until - 1e-9}
            wanted = {name: injected.effect for name, injected in self._wanted.items()}
            for injected in self._wanted.values():
                injected.until = min(injected.until, state.stamp + injected.duration)
        site = self._site = self._site or Site(
            description=self.description,
            state=state,
            world=self._world,
            homes=self._homes,
            rng=self._rng,
        )
        site.state = state
        before, self._effects = self._effects, wanted
        for name, effect in before.items():
            if wanted.get(name) is not effect:
                effect.end()
        for name, effect in wanted.items():
            if before.get(name) is not effect:
                effect.begin(site)

    def _latest(self, max_age: float) -> DepthFrame | None:
        effects = self._effects
        frame = self._robot.camera.latest(inf if effects else max_age)
        for effect in effects.values():
            frame = effect.frame(frame)
        now = self._site.now if self._site is not None else 0.0
        is_old = frame is not None and bool(effects) and now - frame.stamp > max_age
        return None if is_old else frame


def with_faults(backend: Backend, seed: int) -> Backend:
    """A robot, not yet connected, that can be given faults."""
    robot = FaultInjection(backend.robot, backend.truth, seed)
    return replace(backend, robot=robot, injector=robot)


class FaultyWorld:
    """Another world, named by the argument, whose robot can be given faults."""

    is_wrapper = True

    def __call__(self, robot: str, options: WorldOptions) -> Backend:
        """A robot in it; raises as `open_backend` does."""
        inner = open_backend(robot, options.argument or "kinematic", options)
        return with_faults(inner, options.seed)


faulty = FaultyWorld()
