"""A simulated robot that the emulated base, arm and hand move."""

import threading
import time
from collections.abc import Callable, Sequence

import numpy as np
from pinocchio import SE3

from config.planar import Pose2D
from extensions.emulators.panda import ArmLink, Wanted
from extensions.emulators.realsense import Shot
from hw import BaseState, LocalisedPose, WallClock, WorldError, find_world, stopwatch
from hw.sim import (
    D435Noise,
    DepthRenderer,
    Dynamics,
    SimLaser,
    SimulatedWorld,
    load_localisation,
    load_scene,
    made_wrong,
)
from robots import Array, load_robot

STEP = 0.005  # period of the world [s]
_LATE = 0.05  # commands are valid for this long [s]
_CATCH_UP, _MOST_LACKING = 8.0, 0.02  # rate of correction [1/s], up to this error [rad]
_RELEASED = 0.1  # a bumper is released when the base was commanded to rest for this long [s]


class EmulatedWorld:
    """A simulated robot in a thread of its own; the drive of an emulated base."""

    def __init__(
        self,
        robot: str,
        world: str,
        scene: str,
        seed: int,
        link: ArmLink,
        localisation: str = "exact",
    ) -> None:
        self.name, self.scene, self.seed, self.localisation = world, scene, seed, localisation
        level = load_localisation(localisation)
        description, self._process, self._scale = made_wrong(load_robot(robot), level, seed)
        self.truth = load_scene(scene, seed, description.base.size[:2], level.moved)
        self.clock = WallClock()
        moved = find_world(world)
        if not isinstance(moved, SimulatedWorld):
            raise WorldError(f"--world {world}: emulators move a robot of a simulated world")
        make = moved.body()
        self.body = make(description, self.truth, self.clock, Dynamics(period=_LATE), self._process)
        self.lock = threading.RLock()  # protects the simulated robot
        self.bumped = ""  # what the base has hit; empty while it may move
        self.on_bump: Callable[[], None] = lambda: None  # called on a bump
        self._link = link
        self._measured = self._as_measured()
        self._start = self._measured.oTb
        self._mTo = SE3.Identity()
        self._localised: LocalisedPose | None = None
        self._measure()
        self._twist = (0.0, 0.0)
        self._rests_since = 0.0
        self._before: Wanted | None = None
        self._qd: Array = np.zeros(7)
        self._lacks: Array = np.zeros(7)
        self._releases = self._grips = self._ended = 0
        self._renderer = DepthRenderer(description.camera.intrinsics)
        self._noise = D435Noise()
        self._laser = (
            None if description.laser is None else SimLaser(self.body, description.laser, seed)
        )
        self._scans = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="emulated world", daemon=True)
        self._publish()

    def start(self) -> None:
        """Start the thread."""
        import scipy.optimize  # noqa: F401 - the first grasp would stop the world for 0.3 s

        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._over.set()
        self._thread.join()

    def command(self, v: float, w: float) -> None:
        """Move at these velocities from now on [m/s, rad/s]."""
        self._twist = (v, w)

    def pose(self) -> Pose2D:
        """True pose."""
        return _on_floor(self.body.wTb)

    def encoders(self) -> Pose2D:
        """Odometry since the start."""
        return _on_floor(self._start.actInv(self._measured.oTb))

    def localised(self) -> Pose2D:
        """Where the base takes itself to be: where it was localised last, moved by odometry."""
        return _on_floor(self._mTo * self._measured.oTb)

    @property
    def is_lost(self) -> bool:
        """Whether its localisation has an outage."""
        return self._localised is not None and self._measured.localised is None

    def twist(self) -> tuple[float, float]:
        """Velocities as its wheels tell [m/s, rad/s]."""
        vx, _, w = self._measured.twist
        return (float(vx), float(w))

    def echoes(self) -> Sequence[tuple[float, float]]:
        """What the laser sees now: points in the base [m]."""
        if self._laser is None:
            return ()
        with self.lock:
            self._scans += 1
            scan = self._laser.scan(self._scans)
        return [(x, y) for x, y, _ in scan.points[np.isfinite(scan.ranges)].tolist()]

    def capture(self, number: int) -> Shot:
        """An image of this moment, with noise seeded by its number."""
        camera = self.body.description.camera
        with self.lock:
            shapes, wTc, stamp = self.body.shapes(), self.body.wTe * camera.eTc, stopwatch()
        rng = np.random.default_rng((self.seed, number))
        depth = self._noise.apply(self._renderer.render(shapes, wTc), camera, rng)
        return Shot(depth=depth * self._scale, stamp=stamp)

    def _run(self) -> None:
        due = stopwatch()
        while not self._over.is_set():
            with self.lock:
                self._step()
            due = max(due + STEP, stopwatch())
            time.sleep(max(0.0, due - stopwatch()))

    def _step(self) -> None:
        body, before = self.body, self.body.now
        wanted = self._link.wanted()
        body.advance()
        self._lacks -= self._qd * (body.now - before)
        if wanted is not None:
            self._follow(wanted)
        v, w = self._twist
        body.follow(base_twist=np.array([v, 0.0, w]), qd=self._qd)
        self._measure()
        self._check_bumper()
        self._publish()

    def _as_measured(self) -> BaseState:
        """What odometry and localisation tell of the base."""
        body = self.body
        oTb, localised = self._process.read(body.now, body.wTb)
        return BaseState(stamp=body.now, oTb=oTb, twist=body.base_twist, localised=localised)

    def _measure(self) -> None:
        """What the base tells now, with the errors of its level."""
        before, self._measured = self._measured, self._as_measured()
        localised = self._measured.localised
        if localised is not None and localised is not self._localised:
            passed = self._measured.stamp - before.stamp
            share = 1.0 - (self._measured.stamp - localised.stamp) / max(passed, 1e-9)
            then = SE3.Interpolate(before.oTb, self._measured.oTb, min(max(share, 0.0), 1.0))
            self._localised, self._mTo = localised, localised.mTb * then.inverse()

    def _follow(self, wanted: Wanted) -> None:
        body, before = self.body, self._before
        self._before = wanted
        if wanted.releases != self._releases:
            self._releases = wanted.releases
            body.reflex.clear()
        is_silent = stopwatch() - wanted.at > _LATE
        if before is None or is_silent or body.reflex.reason is not None:
            self._qd, self._lacks = np.zeros(7), np.zeros(7)
        elif wanted.at > before.at:
            way = np.subtract(wanted.way, before.way)
            self._lacks += way
            fastest = body.description.limits.qd
            late = np.clip(self._lacks - way, -_MOST_LACKING, _MOST_LACKING)
            self._lacks = way + late
            wish = way / (wanted.at - before.at) + _CATCH_UP * late
            self._qd = np.clip(wish, -fastest, fastest)
        if wanted.grips != self._grips:
            self._grips = wanted.grips
            body.grip(body.width if wanted.stops else wanted.width, wanted.force)
        if not body.fingers_move:
            self._ended = self._grips

    def _check_bumper(self) -> None:
        bumper = self.body.bumper
        if self._twist != (0.0, 0.0):
            self._rests_since = stopwatch()
        elif bumper.reason is not None and stopwatch() - self._rests_since > _RELEASED:
            bumper.clear()
        if bumper.reason and not self.bumped:
            self.on_bump()
        self.bumped = bumper.reason or ""

    def _publish(self) -> None:
        body = self.body
        self._link.tell(
            body.q.tolist(),
            body.qd.tolist(),
            body.width,
            is_stopped=body.reflex.reason is not None,
            releases=self._releases,
            grips=self._ended,
        )


def _on_floor(pose: SE3) -> Pose2D:
    """`Pose2D.of` by numpy, from which it differs in the last bit, as in recorded runs."""
    x, y, _ = pose.translation.tolist()
    return Pose2D(x, y, float(np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])))
