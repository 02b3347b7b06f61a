"""The drivers of one robot from its file."""

from math import radians

from hw.clock import Clock
from hw.omron import ArclSettings, OmronBase, OmronLaser, OmronSettings, Site
from hw.panda import PandaArm, PandaHand
from hw.realsense import RealSenseCamera, RealSenseSettings
from robots import CameraDescription, FullScaleFile, HardwareFile, LaserDescription, Limits


def base_of(hardware: HardwareFile, limits: Limits, clock: Clock) -> OmronBase:
    """The driver of the base, not yet connected."""
    file = hardware.base
    arcl = None
    if file.arcl is not None:
        arcl = ArclSettings(password=file.arcl.password, port=file.arcl.port)
    settings = OmronSettings(
        host=file.address,
        port=file.port,
        user=file.user,
        password=file.password,
        arcl=arcl,
        site=site_of(file.scale),
        acceleration=float(limits.base_acceleration[0]),
        turn_acceleration=float(limits.base_acceleration[2]),
        pose_delay=file.pose_delay,
        laser_delay=file.laser_delay,
        sigma=file.localisation.sigma,
        sigma_turn=radians(file.localisation.sigma_deg),
        least_score=file.least_score,
        score_scale=file.score_scale,
    )
    return OmronBase(settings, clock)


def laser_of(
    base: OmronBase, description: LaserDescription | None, clock: Clock
) -> OmronLaser | None:
    """The driver of the laser, over the connection of the base; None for a robot without one."""
    return None if description is None else OmronLaser(lambda: base.echoes, description, clock)


def arm_of(hardware: HardwareFile, clock: Clock) -> PandaArm:
    """The driver of the arm, not yet connected."""
    return PandaArm(hardware.arm.address, clock, hardware.arm)


def hand_of(hardware: HardwareFile, clock: Clock) -> PandaHand:
    """The driver of the hand, not yet connected."""
    return PandaHand(hardware.arm.address, clock, hardware.gripper.speed)


def camera_of(
    hardware: HardwareFile,
    description: CameraDescription,
    clock: Clock,
    *,
    for_calibration: bool = False,
) -> RealSenseCamera:
    """The driver of the camera, not yet connected; for calibration with infrared, projector off."""
    file = hardware.camera
    emulator = ""
    if hardware.emulated is not None:
        emulator = f"{hardware.base.address}:{hardware.emulated + 1}"
    settings = RealSenseSettings(
        serial="" if emulator else file.serial,
        emulator=emulator,
        rate=file.rate,
        preset=file.preset,
        delay=file.delay,
        infrared=for_calibration,
        emitter=not for_calibration,
    )
    return RealSenseCamera(description, clock, settings)


def site_of(file: FullScaleFile) -> Site:
    """Full-scale values of a robot file."""

    def turn(degrees: float | None) -> float | None:
        return None if degrees is None else radians(degrees)

    return Site(
        forward=file.forward,
        reverse=file.reverse,
        turn=radians(file.turn_deg),
        turn_at_forward=turn(file.turn_at_forward_deg),
        turn_at_reverse=turn(file.turn_at_reverse_deg),
        dead_translation=file.dead_translation,
        dead_rotation=file.dead_rotation,
    )
