"""Files of the Rerun web viewer, extracted once from the viewer's program.

The page loads no foreign fonts, and its content security policy limits the hosts to which the
browser may connect.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import threading
from importlib.metadata import version
from pathlib import Path
from tempfile import mkdtemp
from urllib.error import URLError
from urllib.parse import quote
from urllib.request import ProxyHandler, build_opener

from app.web.ports import LOOPBACK, choose_port
from config import UserError, user_cache
from hw import stopwatch

FILES = {
    "index.html": "text/html; charset=utf-8",
    "re_viewer.js": "text/javascript; charset=utf-8",
    "re_viewer_bg.wasm": "application/wasm",
    "favicon.ico": "image/x-icon",
}

_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "worker-src 'self' blob:; manifest-src 'self'; connect-src {hosts}; "
    "base-uri 'none'; form-action 'none'"
)
ANCESTORS = "http://127.0.0.1:* http://localhost:*"
"""What may frame the viewer: a page under the other name of this host. A browser then runs it in a
process of its own, so that it cannot hold up the page."""
_BRIDGE = (
    "<script>setInterval(() => window._handle && "
    'parent.postMessage(window._handle.viewer_state(), "*"), 500);'
    'addEventListener("message", ({data, source}) => source === parent && window._handle && '
    "window._handle.viewer_control(data));</script>"
)
"""Tells a page around it what it shows, and does what that page asks for, as Rerun encodes both."""
_FOREIGN = re.compile(r"<link\s[^>]*https://[^>]*>")
_PROXIES = ("ALL_PROXY", "HTTPS_PROXY", "HTTP_PROXY", "all_proxy", "https_proxy", "http_proxy")
_PATIENCE = 60.0  # time for the viewer's program to serve its files [s]


class WebFilesError(UserError):
    """The files of the web viewer are not available."""


def viewer_program() -> Path:
    """The viewer binary (the `rerun` on the path is a script that would leave it an orphan).

    Raises WebFilesError: it is not installed.
    """
    found = importlib.util.find_spec("rerun_cli")
    program = Path(found.origin).parent / "rerun" if found and found.origin else None
    if program is None or not program.exists():
        how = f"{sys.executable} -m pip install rerun-sdk, or --view none"
        raise WebFilesError(f"the Rerun viewer is not installed: {how}")
    return program


def viewer_environment() -> dict[str, str]:
    """The environment in which the viewer's program contacts no other host.

    `CI` disables its telemetry; a proxy on which nobody listens disables its check for updates.
    """
    kept = {name: value for name, value in os.environ.items() if "ANALYTICS" not in name}
    return kept | {"CI": "1"} | dict.fromkeys(_PROXIES, f"http://{LOOPBACK}:9")


def viewer_web_files() -> Path:
    """The folder with the files, filled at the first call.

    Raises WebFilesError: the viewer's program is missing or does not serve them.
    """
    kept = user_cache() / f"web-viewer-{version('rerun-sdk')}"
    if all((kept / name).is_file() for name in FILES):
        return kept
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        made = Path(mkdtemp(dir=kept.parent))
        _fetch(made)
        shutil.rmtree(kept, ignore_errors=True)
        made.rename(kept)
    except OSError as error:
        raise WebFilesError(
            f"{kept}: the files of the web viewer cannot be kept ({error}); "
            "set XDG_CACHE_HOME to a folder that is writable and has 50 MB"
        ) from error
    return kept


def read_file(name: str) -> tuple[bytes, str] | None:
    """Content and type of a file by name; None if there is none.

    The page has no foreign links. Raises OSError, WebFilesError: the files are not available.
    """
    if name not in FILES:
        return None
    content = (viewer_web_files() / name).read_bytes()
    if name == "index.html":
        text = _FOREIGN.sub("", content.decode())
        content = text.replace("</body>", f"{_BRIDGE}</body>", 1).encode()
    return content, FILES[name]


def viewer_policy(hosts: str) -> str:
    """The content security policy of the viewer's page."""
    return _POLICY.format(hosts=hosts)


def viewer_address(source: str) -> str:
    """The query of the viewer's page that shows a source in the dark theme."""
    return f"?url={quote(source, safe='')}&theme=dark&hide_welcome_screen=1"


def _fetch(folder: Path) -> None:
    """Let the program serve its files on loopback, and copy them."""
    data, port = choose_port(), choose_port()
    command = [str(viewer_program()), "--serve-web", "--bind", LOOPBACK, "--port", str(data)]
    process = subprocess.Popen(
        [*command, "--web-viewer-port", str(port)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=viewer_environment() | {"BROWSER": "true"},
        start_new_session=True,
    )
    try:
        for name in FILES:
            (folder / name).write_bytes(_get(process, f"http://{LOOPBACK}:{port}/{name}"))
    finally:
        process.terminate()
        process.wait()


def _get(process: subprocess.Popen[bytes], url: str) -> bytes:
    begun, opener = stopwatch(), build_opener(ProxyHandler({}))
    while process.poll() is None and stopwatch() - begun < _PATIENCE:
        try:
            with opener.open(url, timeout=_PATIENCE) as reply:
                content: bytes = reply.read()
                return content
        except (URLError, ConnectionError):
            threading.Event().wait(0.05)
    raise WebFilesError("the Rerun viewer does not hand out its web page; choose --view none")
