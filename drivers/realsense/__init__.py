"""Driver of the RealSense D435: depth images from a process with the vendor's library."""

from drivers.realsense.camera import RealSenseCamera
from drivers.realsense.device_settings import RealSenseSettings, missing
from drivers.realsense.driver import RealSenseOptions
from drivers.realsense.software_device import HEAD, RESET, Introduction
