"""The vendor's pipeline on a camera, a recording or an emulated camera: one stream of frames."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from hw.clock import stopwatch
from hw.realsense.settings import RealSenseSettings
from hw.realsense.software import SoftwareCamera
from hw.realsense.wire import GoneError

_SHARE = 0.8
"""Of the silence after which a camera is lost: then the reason is sought, to be there in time."""

_FIRST = 2.0
"""What a camera that was just opened may take to its first image [s]."""


class LostError(RuntimeError):
    """The camera delivers no images; the text says why and what to do.

    A kind of what the library raises itself, whenever a camera goes.
    """


class HangsError(LostError):
    """The camera is there and sends nothing."""


class EndedError(Exception):
    """The recording is over."""


@dataclass(frozen=True, kw_only=True)
class Identity:
    """What a camera says of itself."""

    name: str
    serial: str
    firmware: str
    recommended: str
    """Firmware that the library is made for; empty if it does not tell."""
    usb: str
    """The version of its connection; empty without a cable."""


class Stream:
    """Frames of one camera; made by `open_stream`.

    Args:
        library: of the vendor.
        settings: of the camera.
        pipeline: that was started.
        profile: that it was started with.
        software: what feeds the camera, if something does.
    """

    def __init__(
        self,
        library: Any,
        settings: RealSenseSettings,
        pipeline: Any,
        profile: Any,
        software: SoftwareCamera | None,
    ) -> None:
        self._library, self._settings = library, settings
        self._pipeline, self._software = pipeline, software
        self._device = profile.get_device()
        self._profile = profile
        self._patience = _FIRST

    @property
    def identity(self) -> Identity:
        """What the camera says of itself."""
        info = self._library.camera_info

        def told(what: Any) -> str:
            has_it = self._device.supports(what)
            return str(self._device.get_info(what)) if has_it else ""

        return Identity(
            name=told(info.name),
            serial=told(info.serial_number),
            firmware=told(info.firmware_version),
            recommended=told(info.recommended_firmware_version),
            usb=told(info.usb_type_descriptor),
        )

    @property
    def depth_scale(self) -> float:
        """What 1 in a depth image is [m]."""
        return float(self._device.first_depth_sensor().get_depth_scale())

    def intrinsics(self, kind: Any) -> Any:
        """Those of the vendor, for one of its streams."""
        return self._profile.get_stream(kind).as_video_stream_profile().get_intrinsics()

    def next(self, before: float) -> Any:
        """The next set of frames; the library is known to give one and the same again and again.

        Args:
            before: stamp of the depth frame that came last [ms].

        Raises:
            LostError: no other one comes within the patience of the settings.
            EndedError: the recording is over.
        """
        until = stopwatch() + self._patience
        while stopwatch() < until:
            try:
                frames = self._pipeline.wait_for_frames(round(1000.0 * self._patience))
            except RuntimeError as error:
                if self._has_ended():
                    raise EndedError from error
                raise self._loss(error) from error
            depth = frames.get_depth_frame()
            if depth and depth.get_timestamp() != before:
                self._patience = _SHARE * self._settings.silence
                return frames
        raise HangsError("it is plugged in and sends the same image again and again")

    def reset(self) -> None:
        """Have the camera start anew, as if it had been unplugged and plugged in again."""
        if self._software is not None:
            self._software.reset()
        elif not self._settings.file:
            with suppress(RuntimeError):
                self._device.hardware_reset()

    def _has_ended(self) -> bool:
        if not self._settings.file:
            return False
        status = self._device.as_playback().current_status()
        return bool(status == self._library.playback_status.stopped)

    def _loss(self, error: RuntimeError) -> LostError:
        """Why no frames come."""
        if self._software is not None and self._software.lost:
            return LostError(self._software.lost)
        if self._settings.file:
            return LostError(f"its recording cannot be read on: {error}")
        if self._software is None and self.identity.serial not in _serials(self._library):
            return LostError(
                "it is not there any more: plug it in, and look at cable and power of the port"
            )
        return HangsError("it is plugged in and sends no images")


@contextmanager
def open_stream(library: Any, settings: RealSenseSettings) -> Iterator[Stream]:
    """Frames of what the settings name.

    Raises:
        LostError: it is not there, or cannot do what is asked of it.
    """
    rs = library
    config, pipeline = rs.config(), rs.pipeline()
    software = None
    try:
        if settings.emulator:
            software = _emulated(rs, settings)
            pipeline.set_device(software.device)
        elif settings.file:
            config.enable_device_from_file(settings.file, settings.repeat)
        else:
            config.enable_device(_serial(rs, settings.serial))
        size = (settings.width, settings.height)
        config.enable_stream(rs.stream.depth, -1, *size, rs.format.z16, settings.rate)
        if settings.infrared:
            config.enable_stream(rs.stream.infrared, 1, *size, rs.format.y8, settings.rate)
        try:
            profile = pipeline.start(config)
        except RuntimeError as error:
            raise LostError(_refusal(settings, error)) from error
        try:
            if software is not None:
                software.start()
            elif not settings.file:
                _set_up(rs, profile.get_device().first_depth_sensor(), settings)
            yield Stream(rs, settings, pipeline, profile, software)
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
    """Of the cameras that are plugged in."""
    number = rs.camera_info.serial_number
    return [one.get_info(number) for one in rs.context().query_devices() if one.supports(number)]


def _serial(rs: Any, wanted: str) -> str:
    """Of the camera to open. The library would wait 15 s for one that is not there.

    Raises:
        LostError: it is not there, or there are several.
    """
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
    """Why the library does not start, for people."""
    text = str(error)
    asked = f"depth of {settings.width} x {settings.height} at {settings.rate} Hz"
    if settings.infrared:
        asked += " with the infrared image"
    if settings.file:
        return f"it cannot be played: {text.partition('Reason: ')[2] or text}"
    if "resolve" in text:
        return f"it has no {asked} here: is it connected by USB 2?"
    if "busy" in text.lower():
        return "another program uses it: end that one"
    return f"it does not start: {text}"


def _set_up(rs: Any, sensor: Any, settings: RealSenseSettings) -> None:
    """Set what the settings choose, as far as this camera knows it."""
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
