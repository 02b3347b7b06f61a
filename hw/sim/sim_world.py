"""Kinematic world: fixtures, objects that can be moved, and moving obstacles."""

from collections.abc import Iterable, Sequence

import numpy as np
from pinocchio import SE3

from controller import Obstacle
from hw.sim.contact import Resting, Vicinity, separation
from hw.sim.grasp_contact import GraspOutcome, Reason, grasp_contact
from hw.sim.sim_object import SimObject, Surface, Visible
from hw.sim.sim_robot_shapes import HAND_TOLERANCE, HELD_TOLERANCE, Hand
from hw.sim.walker import Walker
from hw.truth import Touch
from robots import Array, Geom, Hull

_MIN_LEVEL = 0.3  # smallest horizontal share of a push that moves an object


class World:
    """Fixtures, objects, walkers; `surfaces` are drawn instead of the hulls of their name."""

    def __init__(
        self,
        fixtures: Sequence[Geom],
        objects: Sequence[SimObject],
        walkers: Sequence[Walker] = (),
        unmapped: Sequence[Geom] = (),
        surfaces: Sequence[Surface] = (),
    ) -> None:
        self.fixtures = tuple(fixtures)
        self.mapped = tuple(one for one in fixtures if one not in unmapped)
        self.surfaces = tuple(surfaces)
        self.objects = list(objects)
        self.walkers = tuple(walkers)
        self.touches: list[Touch] = []  # collisions of the robot until now
        self.base: SE3 | None = None  # of the robot, as it moved last
        self.held: SimObject | None = None
        self.given: SimObject | None = None  # a person holds it between the fingers
        self.eTs = SE3.Identity()  # held object in the end effector
        self._held_width = 0.0
        self._vicinity = Vicinity(self.fixtures)
        self._resting = Resting(self.fixtures, self.objects, self._vicinity)
        self._grasped_at: Array | None = None

    def shapes(self) -> list[Visible]:
        """All visual shapes except the robot, in the world."""
        hulls = {one.name for one in self.surfaces}
        plain = (
            one for one in self.fixtures if not (isinstance(one.shape, Hull) and one.name in hulls)
        )
        walking = (part for walker in self.walkers for part in walker.placed())
        lying = (one for obj in self.objects for one in obj.visual())
        return [*plain, *self.surfaces, *walking, *lying]

    def moving(self) -> tuple[Obstacle, ...]:
        """Pose and velocity of the walkers, as a tracker would report them."""
        return tuple([walker.obstacle for walker in self.walkers])

    def find(self, name: str) -> SimObject:
        """The object of that name; raises KeyError."""
        for candidate in self.objects:
            if candidate.name == name:
                return candidate
        raise KeyError(f"no object {name!r}; there are {[o.name for o in self.objects]}")

    def move_to(self, now: float) -> None:
        """Move walkers and moving objects to their poses at a time [s]."""
        for walker in self.walkers:
            walker.move_to(now)
        for obj in self.objects:
            if obj.motion is not None:
                obj.pose = SE3(obj.pose.rotation, obj.motion.position(now))

    def close_fingers(
        self, hand: Hand, width_before: float, force: float, width: float = 0.0
    ) -> GraspOutcome:
        """Close the fingers between widths [m] with a force [N] each; hold what they can."""
        if self.held is not None:
            return GraspOutcome(reason=Reason.HELD, width=self._held_width, object=self.held)
        fixtures = self._vicinity.near(hand.centre, hand.radius)
        result = grasp_contact(hand, width_before, force, self._objects_near(hand), fixtures)
        if result.width <= width:
            return GraspOutcome(reason=Reason.NOTHING, width=width)
        touched = result.object
        if touched is not None and result.wTs is not None:
            touched.pose, touched.motion = result.wTs, None
            if result.reason is Reason.HELD:
                self.held, self._held_width = touched, result.width
                self._grasped_at = result.wTs.translation.copy()
                self.eTs = hand.wTe.actInv(result.wTs)
            else:
                self._resting.drop(touched, None)
        return result

    def open_fingers(self) -> None:
        """Release the held object: it falls straight down onto what is below it."""
        if self.held is not None:
            dropped, self.held = self.held, None
            self._resting.drop(dropped, None)

    def put(self, name: str, wTs: SE3) -> None:
        """Move an object, out of the hand if it is held; it falls. KeyError: there is none."""
        obj = self.find(name)
        if obj is self.held:
            self.held = None
        obj.pose, obj.motion = wTs, None
        self._resting.drop(obj, self.held)

    def give(self, name: str) -> None:
        """A person holds an object between the fingers, until they have it."""
        self.given = self.find(name)

    def carry(self, wTe: SE3) -> None:
        """Move the held object along with the end effector."""
        if self.held is not None:
            self.held.pose = wTe * self.eTs

    def push(self, obj: SimObject, towards: Array, depth: float) -> None:
        """Let an object that is pressed along (3,) to a depth [m] slide away, if it can."""
        level = np.array([towards[0], towards[1], 0.0])
        share = float(np.linalg.norm(level))
        if share > _MIN_LEVEL:
            obj.motion = None
            self._resting.push(obj, level * depth / share**2, self.held)
            self._resting.settle(self.held)

    def settle(self) -> None:
        """Let objects that lay on the held one fall, once that has left its place."""
        if self.held is None or self._grasped_at is None:
            return
        gone = np.linalg.norm(self.held.pose.translation - self._grasped_at)
        if gone > 2.0 * self.held.radius:
            self._grasped_at = None
            self._resting.settle(self.held)

    def collision(self, hand: Hand, width: float) -> str | None:
        """Name of a shape that hand or held object, at a width [m], penetrates beyond tolerance."""
        nearby = self._vicinity.near(hand.centre, hand.radius)
        nearby += [part for o in self._objects_near(hand) for part in o.placed()]
        if nearby and (hit := _deepest(hand.shapes(width), nearby, HAND_TOLERANCE)):
            return hit
        if self.held is not None:
            around = self._vicinity.near(self.held.pose.translation, self.held.radius)
            return _deepest(self.held.placed(), around, HELD_TOLERANCE)
        return None

    def resting_on(self, obj: SimObject) -> str:
        """Group of the fixture that carries an object; see `Resting.support`."""
        return self._resting.support(obj, self.held)

    def supports(self) -> dict[str, str]:
        """What each object rests on, by its name."""
        return {obj.name: self.resting_on(obj) for obj in self.objects}

    def _objects_near(self, hand: Hand) -> list[SimObject]:
        centre, radius = hand.centre, hand.radius
        return [
            o
            for o in self.objects
            if o is not self.held
            and np.linalg.norm(o.pose.translation - centre) < radius + o.radius
        ]


def _deepest(shapes: Iterable[Geom], others: Sequence[Geom], tolerance: float) -> str | None:
    """Name of the shape with the deepest penetration beyond a tolerance [m]."""
    worst, name = -tolerance, None
    for shape in shapes:
        for other in others:
            gap, _ = separation(shape, other)
            if gap < worst:
                worst, name = gap, other.name
    return name
