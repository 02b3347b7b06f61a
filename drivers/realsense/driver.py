"""An Intel RealSense D435 below `hardware` in a robot file."""

from typing import Literal

from drivers.realsense.camera import RealSenseCamera
from drivers.realsense.device_settings import RealSenseSettings
from hw import DriverContext
from robots import DriverOptions, NotNegative


class RealSenseOptions(DriverOptions):
    """An Intel RealSense D435."""

    serial: str = ""  # empty for the only camera
    rate: Literal[6, 15, 30, 60, 90] = 30  # [Hz]
    preset: str = "High Density"
    delay: NotNegative = 0.0  # age of an image at its stamp [s]
    infrared: bool = False  # with the left infrared image, for calibration
    emitter: bool = True  # whether the projector is on; its dots disturb infrared images


def realsense_camera(options: RealSenseOptions, context: DriverContext) -> RealSenseCamera:
    """The driver of the camera."""
    given = options.model_dump(exclude={"driver"} | ({"serial"} if context.emulator else set()))
    settings = RealSenseSettings(**given, emulator=context.emulator)
    return RealSenseCamera(context.robot.camera, context.clock, settings)
