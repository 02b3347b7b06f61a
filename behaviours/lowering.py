"""The motion of the held object down to a place: over it, a look, down, and the release."""

from abc import abstractmethod
from collections.abc import Callable

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.directions import way_out
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Progress
from behaviours.core.parameter_types import Region
from behaviours.release import TILT, Release, Spot
from behaviours.views.surface import SurfaceWatch
from behaviours.views.viewpoint import CAMERA_PATIENCE, hidden_by, out_of_view
from config.poses import OdometryPose
from controller import Array, PoseGoal, StepReport
from hw import FaultKind, TaskTime
from perception import disc

_MOST_RELOCALISATIONS = 3  # after which the hand goes back over the place
_MOST_UNSEEN = 1  # places that are skipped as they are not seen
_POINTS = 50  # of the place that the camera is to see
_MOST_SIDES = 3  # from which the camera looks at a place
_MOST_STUCK = 1  # places that are skipped as the hand does not get there
ABOVE, _LEAST_ABOVE = 0.12, 0.06  # height over the place, and where that is out of reach [m]
_BARELY = np.array([0.0, 0.0, 0.03])  # below what is near, it comes in so high [m]
_APPROACH_SPEED, _APPROACH_TOLERANCE = 0.6, 0.015  # [m/s, m]
_LOWER_SPEED, _LOWER_TOLERANCE = 0.25, 0.007  # [m/s, m]


class Lowering(Leaf):
    """Sets the held object down; a subclass says where, and what follows."""

    _step: Callable[[], Status]
    _on: Region  # whose floor it is set down on
    _number: int | None  # of the place there
    _watch: SurfaceWatch  # looks at the place
    _radius: float  # of the disc around the place that has to be free [m]
    _rotation: Array  # (3, 3) of the hand that sets down, in odometry
    _down: SE3  # the hand at the release, in odometry
    _asides: list[SE3]  # hands that let the camera see the place, in odometry
    _up: float  # how far the hand comes from above [m]
    _looking_since: TaskTime | None
    _is_high: bool  # depends on its stance: straight down on what is above the shoulder
    _is_below: bool  # whether something is near above
    _goes_straight: bool  # until it gets stuck

    @property
    @abstractmethod
    def _place(self) -> str:
        """For messages."""

    @abstractmethod
    def _aim(self) -> None:
        """Take the place where it is by the newest estimate of the map."""

    @abstractmethod
    def _look(self) -> str | None:
        """Look at the place; returns why nothing can be placed, if so."""

    @abstractmethod
    def _pass_over(self) -> str | None:
        """Choose another place; returns why not, if so."""

    @abstractmethod
    def _let_go(self) -> Status:
        """One tick of the release."""

    def _begin_anew(self) -> None:
        """Forget what has gone wrong before."""
        self._relocalised = self._unseen = self._stuck = 0
        self._progress = Progress(self.context)

    @property
    def phase(self) -> str:
        """`approach` until the hand is over the place, then `lower`, `release` and `rise`."""
        if self._step == self._let_go:
            return self._releasing.phase
        return "lower" if self._step == self._lower else "approach"

    def update(self) -> Status:
        """One tick of the phase that the placing is in."""
        if fault := self.fault():
            if any(one.kind is FaultKind.REFLEX for one in self.context.state.faults):
                self._block()
            return self.failure(fault)
        if self._step in (self._approach, self._give_way, self._lower) and (reason := self._look()):
            return self.failure(reason)
        return self._step()

    def _approach(self) -> Status:
        self._aim()
        speed, tolerance = _APPROACH_SPEED, _APPROACH_TOLERANCE
        return self._move("over the place", self._above, speed, tolerance, self._arrive)

    @property
    def _shown(self) -> Array:
        """(N, 3) points that the camera is to see, in odometry [m]."""
        return disc(self._watch.centre, self._radius, _POINTS)

    def _set_out(self) -> None:
        """Go over the place: straight, or the base to another stance first."""
        self._step = self._approach
        self._progress = Progress(self.context, straight=self._is_straight)

    def _less_high_or_elsewhere(self, report: StepReport) -> Status:
        """Come from less high if that is out of reach; else go to another place."""
        if report.unreachable and self._up > _LEAST_ABOVE:
            self._up = _LEAST_ABOVE
        else:
            away = f"over the place: stuck {report.position_error:.2f} m away"
            if not report.unreachable:
                self._note(self.context.log.places_blocked)
                self._stuck += 1
            if self._stuck > _MOST_STUCK or self._pass_over():
                return self.failure(away + self._progress.because)
        self._set_out()
        return self.running(f"going to {self._place}")

    def _arrive(self) -> Status:
        """Go down if the surface was seen on the way, else look for it."""
        self._progress = Progress(self.context)
        if self._watch.has_seen_surface:
            self._step = self._lower
            return self._lower()
        if self._looking_since is None:
            self._looking_since = self.context.clock.now()
        self._step = self._give_way
        self._asides = out_of_view(self.context, self._above, self._shown)[:_MOST_SIDES]
        return self.running("looking at the place")

    def _give_way(self) -> Status:
        """Move the held object, which may hide the place, out of the view, and come back."""
        context, since = self.context, self._looking_since
        if self._watch.has_seen_surface:
            self._set_out()
            return self._approach()
        late = since is not None and context.clock.now() - since > CAMERA_PATIENCE
        reason = context.vision.blindness(context.state.stamp)
        if late and not reason and len(self._asides) > 1:
            self._asides, self._looking_since = self._asides[1:], context.clock.now()
        elif late:
            here, self._unseen = self._place, self._unseen + 1
            [(why, most)] = hidden_by(context, context.oTe, self._shown).most_common(1)
            why = f": {why}" if most else ""
            if not reason:
                self._note(self.context.log.places_unseen)
            if reason or self._unseen > _MOST_UNSEEN or self._pass_over():
                return self.failure(reason or f"{here} is not seen{why}")
            return self.running(f"{here} is not seen{why}, going to {self._place}")
        goal = PoseGoal(target=self._asides[0], speed=_APPROACH_SPEED, straight=True)
        self.pursue(goal, "looking at the place")
        return self.running("looking at the place")

    def _lower(self) -> Status:
        if self.context.now.relocalised:
            return self._go_back()
        return self._move("lowering", self._down, _LOWER_SPEED, _LOWER_TOLERANCE, self._release)

    def _go_back(self) -> Status:
        """Go over the place again after a relocalisation."""
        self._relocalised += 1
        if self._relocalised > _MOST_RELOCALISATIONS:
            return self.failure(self.context.now.relocalised)
        self._set_out()
        return self._approach()

    def _release(self) -> Status:
        watch = self._watch
        self._releasing = Release(
            self,
            self._goal,
            spot=Spot(self._place, watch.centre, self._radius, watch.heights),
            up=self._up,
            backs_off=self._is_high,
            used=lambda: self._note(self.context.log.places_used),
        )
        self._step = self._let_go
        return self.running("letting go")

    def _block(self) -> None:
        """Remember a place at which lowering failed."""
        if self._step == self._lower:
            self._note(self.context.log.places_blocked)

    def _note(self, places: dict[str, set[int]]) -> None:
        if self._number is not None:
            places.setdefault(self._on.name, set()).add(self._number)

    def _move(
        self,
        what: str,
        oTe: OdometryPose,
        speed: float,
        tolerance: float,
        then: Callable[[], Status],
    ) -> Status:
        """One tick of a straight motion of the hand, then the next phase."""
        if reason := self.empty_hand:
            if self._step == self._lower and self.fingers_have_opened:
                return self._release()  # it stands already, and turns in the fingers
            return self.failure(f"nothing left to place: {reason}")
        self._goal = PoseGoal(
            target=oTe,
            speed=speed,
            position_tolerance=tolerance,
            orientation_tolerance=TILT,
            straight=self._step != self._approach or self._is_straight,
            stance_if_near=True,
            hand_may_touch=self._step == self._lower,
            base_rests=self._step == self._lower,
        )
        report = self.pursue(self._goal, f"{what} {self._number} from {self._up:.2f} m")
        if report is None:
            return self.running(what)
        if report.arrived:
            self._step, self._progress = then, Progress(self.context, straight=True)
            return then()
        if not self._progress.is_stuck(report):
            return self.running(f"{what}, {report.position_error:.2f} m to go")
        if self._step == self._approach and self._is_straight:
            self._goes_straight = False
            self._set_out()
            return self.running(f"{what}, from another stance")
        if self._step == self._approach:
            return self._less_high_or_elsewhere(report)
        self._block()
        away = f"{what}: stuck {report.position_error:.2f} m away"
        return self.failure(away + self._progress.because)

    @property
    def _is_straight(self) -> bool:
        """Whether it goes over the place without another stance first."""
        return self._goes_straight and not self._is_high

    @property
    def _above(self) -> SE3:
        """Where the hand comes from and goes back to."""
        out = _BARELY if self._is_below else self._up * way_out(self._rotation)
        return SE3(self._rotation, self._down.translation + out)
