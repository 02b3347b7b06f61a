"""The vendor's pipeline on a camera or an emulated one: one stream of frames."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from drivers.realsense.device_settings import HEIGHT, SILENCE, WIDTH, RealSenseSettings, Status
from drivers.realsense.software_device import GoneError, SoftwareCamera
from hw.clock import stopwatch

_PATIENCE = 0.8 * SILENCE  # to find the reason before the camera counts as lost [s]
_FIRST = 2.0  # longest time to the first image of an opened camera [s]


class LostError(RuntimeError):
    """No images; the text says why. A `RuntimeError`, as the library raises for a lost camera."""


class HangsError(LostError):
    """The camera is plugged in and sends nothing."""


class Stream:
    """Frames of one camera; made by `open_stream`."""

    def __init__(
        self, library: Any, pipeline: Any, profile: Any, software: SoftwareCamera | None
    ) -> None:
        self._library, self._pipeline, self._software = library, pipeline, software
        self._device, self._patience = profile.get_device(), _FIRST
        info = library.camera_info

        def text(what: Any) -> str:
            return str(self._device.get_info(what)) if self._device.supports(what) else ""

        self.identity = Status(
            name=text(info.name),
            serial=text(info.serial_number),
            firmware=text(info.firmware_version),
            recommended=text(info.recommended_firmware_version),
            usb=text(info.usb_type_descriptor),
        )
        self.depth_scale = float(self._device.first_depth_sensor().get_depth_scale())
        """One unit of a depth image [m]."""
        depth = profile.get_stream(library.stream.depth).as_video_stream_profile()
        self.depth_intrinsics: Any = depth.get_intrinsics()  # of the vendor's library

    def next(self, before: float) -> Any:
        """The next new set of frames; LostError: none comes in time."""
        until = stopwatch() + self._patience
        while stopwatch() < until:
            try:
                frames = self._pipeline.wait_for_frames(round(1000.0 * self._patience))
            except RuntimeError as error:
                raise self._loss() from error
            depth = frames.get_depth_frame()
            if depth and depth.get_timestamp() != before:
                self._patience = _PATIENCE
                return frames
        raise HangsError("it is plugged in and sends the same image again and again")

    def reset(self) -> None:
        """Restart the camera, as if it had been unplugged and plugged in again."""
        if self._software is not None:
            self._software.reset()
        else:
            with suppress(RuntimeError):
                self._device.hardware_reset()

    def _loss(self) -> LostError:
        if self._software is not None and self._software.lost:
            return LostError(self._software.lost)
        if self._software is None and self.identity.serial not in _serials(self._library):
            return LostError(
                "it is not there any more: plug it in, and look at cable and power of the port"
            )
        return HangsError("it is plugged in and sends no images")


@contextmanager
def open_stream(library: Any, settings: RealSenseSettings) -> Iterator[Stream]:
    """The stream of the camera that the settings name; LostError: it is not there, or cannot."""
    rs = library
    config, pipeline = rs.config(), rs.pipeline()
    software = None
    try:
        if settings.emulator:
            software = _emulated(rs, settings)
            pipeline.set_device(software.device)
        else:
            config.enable_device(_serial(rs, settings.serial))
        config.enable_stream(rs.stream.depth, -1, WIDTH, HEIGHT, rs.format.z16, settings.rate)
        if settings.infrared:
            config.enable_stream(rs.stream.infrared, 1, WIDTH, HEIGHT, rs.format.y8, settings.rate)
        try:
            profile = pipeline.start(config)
        except RuntimeError as error:
            raise LostError(_refusal(settings, error)) from error
        try:
            if software is not None:
                software.start()
            else:
                _set_up(rs, profile.get_device().first_depth_sensor(), settings)
            yield Stream(rs, pipeline, profile, software)
        finally:
            with suppress(RuntimeError):  # of a camera that is gone
                pipeline.stop()
    finally:
        if software is not None:
            software.close()


def _emulated(rs: Any, settings: RealSenseSettings) -> SoftwareCamera:
    try:
        software = SoftwareCamera(rs, settings.emulator)
    except GoneError as error:
        raise LostError(str(error)) from error
    if settings.infrared and not software.introduction.infrared:
        software.close()
        raise LostError("the emulated camera has no infrared images")
    return software


def _serials(rs: Any) -> list[str]:
    number = rs.camera_info.serial_number
    return [one.get_info(number) for one in rs.context().query_devices() if one.supports(number)]


def _serial(rs: Any, wanted: str) -> str:
    """Serial number of the camera to open; the library would wait 15 s for one that is missing."""
    there = _serials(rs)
    if not there:
        raise LostError("no camera is plugged in: look at the cable (USB 3) and at the udev rules")
    if wanted in there:
        return wanted
    if wanted:
        raise LostError(f"no camera has the serial number {wanted}; there are {', '.join(there)}")
    if len(there) > 1:
        raise LostError(f"there are several cameras: give the `serial` of one, {', '.join(there)}")
    return str(there[0])


def _refusal(settings: RealSenseSettings, error: RuntimeError) -> str:
    text = str(error)
    asked = f"depth of {WIDTH} x {HEIGHT} at {settings.rate} Hz"
    if settings.infrared:
        asked += " with the infrared image"
    if "resolve" in text:
        return f"it has no {asked} here: is it connected by USB 2?"
    if "busy" in text.lower():
        return "another program uses it: end that one"
    return f"it does not start: {text}"


def _set_up(rs: Any, sensor: Any, settings: RealSenseSettings) -> None:
    option = rs.option
    wanted = {
        option.global_time_enabled: 1.0,
        option.emitter_enabled: 1.0 if settings.emitter else 0.0,
    }
    if settings.preset and sensor.supports(option.visual_preset):
        presets = sensor.get_option_range(option.visual_preset)
        for number in range(int(presets.min), int(presets.max) + 1):
            name = sensor.get_option_value_description(option.visual_preset, number)
            if name == settings.preset:
                sensor.set_option(option.visual_preset, number)
    for one, value in wanted.items():
        if sensor.supports(one):
            sensor.set_option(one, value)
