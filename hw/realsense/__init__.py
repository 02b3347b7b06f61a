"""Driver of the RealSense D435: depth images from a process with the vendor's library."""

from hw.realsense.camera import RealSenseCamera
from hw.realsense.device_settings import RealSenseSettings, missing
from hw.realsense.driver import RealSenseOptions
from hw.realsense.software_device import HEAD, RESET, Introduction
