"""The viewer without a window, for screenshots and tests; it needs a Vulkan driver.

Without a graphics card, `apt-get install mesa-vulkan-drivers` provides one.
"""

import re
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from app.live import ViewError
from app.web import LOOPBACK, choose_port, viewer_environment, viewer_program
from hw import stopwatch

_DRIVERS = Path("/usr/share/vulkan/icd.d")
_PATIENCE = 60.0


@dataclass(frozen=True, kw_only=True, eq=False)
class HeadlessViewer:
    """A running viewer."""

    client: Any  # Rerun's `ViewerClient` for it
    process: subprocess.Popen[bytes]

    @property
    def cursor(self) -> float:
        """Its time in the newest recording [s]; -1 if there is none."""
        recordings = self.client.get_state().recordings
        if not recordings or recordings[-1].current_time is None:
            return -1.0
        return float(recordings[-1].current_time) / 1e9


def has_vulkan() -> bool:
    """Whether there is a Vulkan driver."""
    return any(_DRIVERS.glob("*.json"))


@contextmanager
def headless_viewer(
    *, watch: str | None = None, size: str = "1600x1000"
) -> Iterator[HeadlessViewer]:
    """Run a viewer within the context, for live data (`Address.url`) if given.

    Raises ViewError: it does not start.
    """
    port = choose_port()
    command = [str(viewer_program()), "--headless", "--bind", LOOPBACK, "--port", str(port)]
    command += ["--window-size", size, *(() if watch is None else ("--connect", watch))]
    with TemporaryDirectory() as folder:
        log = Path(folder) / "viewer.log"
        with log.open("wb") as out:
            environment = viewer_environment() | {"XDG_RUNTIME_DIR": folder}
            process = subprocess.Popen(command, stdout=out, stderr=out, env=environment)
        try:
            client = _connected(process, f"rerun+http://{LOOPBACK}:{port}/proxy", log)
            yield HeadlessViewer(client=client, process=process)
        finally:
            process.terminate()
            process.wait()


def _connected(process: subprocess.Popen[bytes], url: str, log: Path) -> Any:
    from rerun.experimental import ViewerClient

    begun = stopwatch()
    while True:
        try:
            return ViewerClient.connect(url)
        except Exception as error:  # Rerun raises many kinds while nobody listens
            if process.poll() is not None or stopwatch() - begun > _PATIENCE:
                if not has_vulkan():
                    hint = "on Debian and Ubuntu, apt-get install mesa-vulkan-drivers"
                    raise ViewError(f"the viewer needs a Vulkan driver: {hint}") from error
                said = re.sub(r"\x1b\[[\d;]*m", "", log.read_text(errors="replace")).splitlines()
                why = next((line for line in said if "rror" in line), "it does not say why")
                raise ViewError(f"the viewer does not start: {why}") from error
            threading.Event().wait(0.1)
