"""An Intel RealSense D435 below `hardware` in a robot file."""

from typing import Literal

from hw.drivers import DriverContext
from hw.realsense.camera import RealSenseCamera
from hw.realsense.settings import RealSenseSettings
from robots import DriverOptions, NotNegative


class RealSenseOptions(DriverOptions):
    """An Intel RealSense D435."""

    serial: str = ""  # empty for the only camera
    rate: Literal[6, 15, 30, 60, 90] = 30  # [Hz]
    preset: str = "High Density"
    delay: NotNegative = 0.0  # age of an image at its stamp [s]


def realsense_camera(
    options: RealSenseOptions, context: DriverContext, *, for_calibration: bool = False
) -> RealSenseCamera:
    """The driver of the camera; for calibration with infrared, projector off."""
    settings = RealSenseSettings(
        serial="" if context.emulator else options.serial,
        emulator=context.emulator,
        rate=options.rate,
        preset=options.preset,
        delay=options.delay,
        infrared=for_calibration,
        emitter=not for_calibration,
    )
    return RealSenseCamera(context.robot.camera, context.clock, settings)
