"""Driver of the RealSense D435: depth images from a process of its own with the vendor's library.

`camera` is the part of a robot and `camera_process` the process behind it. `stream` opens a camera
or an emulated one (`software_device`), `timestamps` estimates capture times, `rectifier` maps
images to the intrinsics of the robot description, `image_buffer` is the memory that both processes
share. docs/hardware.md says which parts were verified on hardware.
"""

from hw.realsense.camera import RealSenseCamera
from hw.realsense.settings import RealSenseSettings, missing
from hw.realsense.software_device import HEAD, RESET, Introduction
