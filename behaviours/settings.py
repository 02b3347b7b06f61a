"""What a person may tune about the behaviours; the defaults suit Frankie."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians

from controller import Checked


@dataclass(frozen=True, kw_only=True)
class FingerSettings(Checked):
    """When fingers are open, closed or stuck."""

    closed: float = 0.0015
    """Fingers nearer to each other than this hold nothing [m]."""
    open_share: float = 0.95
    """Share of the full opening from which they count as open."""
    opening_force: float = 20.0
    """Force with which they open [N]."""
    least_motion: float = 0.0005
    """Fingers that have moved less than this have not moved [m]."""
    slack: float = 0.008
    """Fingers that open by more than this have let go; by less, what they hold has turned, or was
    pressed against something [m]."""
    start_patience: float = 0.5
    """Fingers that have not moved this long after they were told to do not move [s]."""
    patience: float = 3.0
    """Fingers that still move after this do not do what they were told [s]."""


@dataclass(frozen=True, kw_only=True)
class ProgressSettings(Checked):
    """When a motion counts as stuck."""

    metres_per_radian: float = 0.3
    """What a radian counts in the distance that is left: about the length of the hand [m/rad]."""
    step: float = 0.005
    """Smallest improvement that counts [m, s or rad]."""
    at_rest: float = 0.03
    """A robot that is slower than this stands still [m/s and rad/s]."""
    patience: float = 2.5
    """No improvement for this long, the robot at rest, is stuck [s]."""
    detour_patience: float = 12.0
    """The same while it moves: a base that swings round brings the hand no nearer at first [s]."""
    straight_patience: float = 2.0
    """The same where the hand is to go straight [s]."""
    longest_tick: float = 0.1
    """Of a longer time between two ticks only this much counts [s]."""


@dataclass(frozen=True, kw_only=True)
class RelocalisationSettings(Checked):
    """When the pose of the base has jumped."""

    distance: float = 0.03
    """It differs this much from what its motion explains [m] ..."""
    turn: float = radians(2.0)
    """... or is turned this much [rad] ..."""
    window: float = 0.25
    """... within this time [s]."""
    correction: float = 0.1
    """A localisation corrects itself by at most this much [m] ..."""
    correction_turn: float = radians(8.0)
    """... and this much [rad]; after more it is not certain which of both was wrong."""


@dataclass(frozen=True, kw_only=True)
class GraspSettings(Checked):
    """How the hand follows a grasp and goes down on it."""

    standoff: float = 0.12
    """Height over the grasp where the hand waits until it is locked and below [m]."""
    above_position: float = 0.009
    """The hand goes down when it stands over the locked grasp this precisely [m] ..."""
    above_angle: float = radians(3.0)
    """... and turned this little [rad]."""
    other_target: float = 0.03
    """A grasp that jumps this far is another one, and gets the full time to be reached [m]."""
    nearer_standoff: float = 0.24
    """Where a grasp is out of reach from here, the base takes a stance for this height over it,
    from which the hand is free to go round [m] ..."""
    nearer_tolerance: float = 0.03
    """... and the hand follows the grasp again when it is this near to that [m]."""
    looks: int = 2
    """How often an attempt looks again from straight above, where it sees no grasp or only a
    doubtful one."""
    look_height: float = 0.4
    """Height of the camera then over what is looked at [m]."""
    doubtful: float = 0.1
    """The hand does not go down on a grasp of less quality before it has looked again. Where it is
    told how likely grasps hold, those of so little quality are none anyway."""
    follow_speed: float = 0.5
    """[m/s]."""
    descend_speed: float = 0.25
    """[m/s]."""
    astray: float = 0.012
    """A hand that is this far beside its way down comes back over the grasp first [m] ..."""
    astray_above: float = 0.02
    """... unless it is nearer than this to the grasp [m]."""
    descend_tolerance: float = 0.004
    """The fingers close this near to the grasp [m] ..."""
    closing_speed: float = 0.015
    """... when the hand goes down slower than this: it presses what it holds on the floor [m/s]."""


@dataclass(frozen=True, kw_only=True)
class PlaceSettings(Checked):
    """How an object is set down."""

    clearance: float = 0.004
    """Height of object and finger tips over the surface at which it is released [m]."""
    tilt: float = radians(2.0)
    """Tilt that the hand may have then [rad]."""
    most_relocalisations: int = 3
    """How often the hand goes back over the place because the base was relocalised."""
    most_unseen: int = 1
    """How many places the hand goes on from because they were not seen."""
    above: float = 0.12
    """Height over the place that the hand comes from and goes back to [m]."""
    least_above: float = 0.06
    """The same where the place is out of reach from higher up [m]."""
    most_stuck: int = 1
    """How many places the hand goes on from because it did not get there."""
    approach_speed: float = 0.6
    """[m/s]."""
    approach_tolerance: float = 0.015
    """[m]."""
    lower_speed: float = 0.25
    """[m/s]."""
    lower_tolerance: float = 0.007
    """[m]."""
    let_go: float = 0.02
    """The hand rises as soon as the fingers have opened by this much [m]."""
    rise_speed: float = 0.5
    """[m/s]."""
    rise_tolerance: float = 0.03
    """[m]."""
    look_above: float = 0.12
    """The hand rises this much higher if by then it is not seen whether the object stands [m]."""


@dataclass(frozen=True, kw_only=True)
class SurfaceSettings(Checked):
    """How a place is looked at before something is set down on it."""

    radius: float = 0.06
    """Of the disc round the centre of the place that is looked at [m]."""
    pitch_share: float = 0.45
    """The radius is at most this share of the distance between neighbouring places."""
    far: float = 0.7
    """The camera looks from nearer than this [m]."""
    aside: float = 0.18
    """How far the hand gives way to the camera if the place was not seen by then [m]."""
    points: int = 300
    """How many points of the disc are looked at."""
    tolerance: float = 0.015
    """The surface is where it has to be if it is at most this much higher or lower [m]."""
    stray: float = 0.1
    """Share of the points that may be lower."""
    stray_higher: float = 0.03
    """Share of the points that may be higher."""
    least_seen: float = 0.3
    """Share of the points through which one frame has to show the surface to tell that it does."""
    least_known: float = 0.9
    """Share of the points at which the surface has to be seen, in one frame or bit by bit, before
    the hand is lowered; the hand and what it holds hide a part in each."""
    below_hand: float = 0.03
    """What reaches up to this near to the lower end of what is held belongs to it [m]."""
    memory: float = 2.0
    """The surface was seen at most so long before the hand is lowered [s]."""


@dataclass(frozen=True, kw_only=True)
class RetreatSettings(Checked):
    """How the hand rises, after a grasp or out of a fault."""

    speed: float = 0.5
    """After a grasp [m/s]."""
    recovery_speed: float = 0.3
    """Out of a fault, where something may be in the way [m/s]."""
    tolerance: float = 0.03
    """[m]."""


@dataclass(frozen=True, kw_only=True)
class RecoverSettings(Checked):
    """How the arm comes back to a posture."""

    folded: float = 0.05
    """Nearer than this to the posture there is nothing to rise out of [rad]."""
    pauses: tuple[float, ...] = (0.5, 2.0, 8.0)
    """The first fault is cleared after so long, the next so long after that at least, and so on
    [s] ..."""
    lately: float = 30.0
    """... as long as they follow each other faster than this [s]."""
    most: int = 3
    """What comes back at the same place, after so many recoveries, is left to a person."""
    same_place: float = 0.5
    """It is the same place where the base is nearer than this to where it was then [m] ..."""
    same_place_of_hand: float = 0.1
    """... or the hand, for a reflex of the arm [m]."""
    remembered: float = 300.0
    """What was hit stands there for so long, and is no longer counted after it: it may have been a
    person or a chair. What stays there belongs on the map [s]."""
    hit_radius: float = 0.08
    """Of the upright cylinder that stands for what the base has hit [m]."""
    hit_half: float = 0.02
    """Half the edge of the box that stands for what the hand has hit [m]."""
    away_speed: float = 0.15
    """Of the base and the hand on their way from what they have hit [m/s]."""
    way_back: float = 0.05
    """The hand goes back this far along the way that it came, before it rises [m]."""
    in_the_way: float = 0.05
    """Furniture nearer than this keeps the arm from its posture, or the base from its way [m]."""
    back_off: float = 0.3
    """The base backs off from it by this much at a time [m]; also from what stands on a surface
    higher than the shoulder, before the arm goes down beside it ..."""
    most_back_offs: int = 2
    """... and this often."""


@dataclass(frozen=True, kw_only=True)
class ViewSettings(Checked):
    """How the camera is pointed and what it is believed."""

    speed: float = 0.5
    """Of the hand that turns the camera [m/s]."""
    at_rest: float = 0.05
    """Slower than this the hand stands still [m/s and rad/s]."""
    patience: float = 2.0
    """A camera that gives no frame for longer than this is blind [s]."""
    width_per_height: float = 0.8
    """Side of the square that one picture shows well, per height of the camera."""
    over_object: float = 0.4
    """Height of the camera over an object that it is sent to [m]."""
    least_seen: float = 0.98
    """Share of a region that must be seen to say that nothing, or nothing else, stands in it."""
    least_seen_around_objects: float = 0.9
    """The same to count what stands in it: objects hide a part."""
    most_overlooked: float = 0.01
    """It is not called empty where what is higher than this may be overlooked [m]."""


@dataclass(frozen=True, kw_only=True)
class OccupancySettings(Checked):
    """How depth frames become a picture of a region from above."""

    cell: float = 0.003
    """Side of a cell [m]."""
    stride: int = 2
    """Only every n-th pixel is used, along rows and columns."""


@dataclass(frozen=True, kw_only=True)
class FollowSettings(Checked):
    """How a moving object is followed."""

    speed: float = 0.5
    """[m/s]."""
    smallest_area: float = 2e-4
    """What covers less than this, seen from above, is not followed [m^2]."""
    same_object: float = 0.10
    """An object farther than this from where it was in the last picture is another one [m]."""
    still_radius: float = 0.01
    """An object that has not left a circle of this radius stands still [m]."""
    keeping_up: float = 0.05
    """Nearer than this to where it wants to be, the hand keeps up with the object [m]."""


@dataclass(frozen=True, kw_only=True)
class BehaviourSettings:
    """Everything together; a `Context` carries it to all leaves."""

    fingers: FingerSettings = field(default_factory=FingerSettings)
    progress: ProgressSettings = field(default_factory=ProgressSettings)
    relocalisation: RelocalisationSettings = field(default_factory=RelocalisationSettings)
    grasp: GraspSettings = field(default_factory=GraspSettings)
    place: PlaceSettings = field(default_factory=PlaceSettings)
    surface: SurfaceSettings = field(default_factory=SurfaceSettings)
    retreat: RetreatSettings = field(default_factory=RetreatSettings)
    recover: RecoverSettings = field(default_factory=RecoverSettings)
    view: ViewSettings = field(default_factory=ViewSettings)
    counting: OccupancySettings = field(default_factory=OccupancySettings)
    """Where objects are counted."""
    glance: OccupancySettings = field(
        default_factory=lambda: OccupancySettings(cell=0.008, stride=3)
    )
    """Where every frame is looked at within its tick."""
    follow: FollowSettings = field(default_factory=FollowSettings)
