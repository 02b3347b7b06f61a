"""A language model behind an OpenAI-compatible endpoint."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from threading import Event, Timer
from typing import Any, TypeAlias
from urllib.parse import urlsplit

from app.terminal import visible
from config import UserError

_LONGEST = 1_000_000  # of an answer [bytes]
_PAUSES = (1.0, 2.0, 4.0)  # before another try, where the endpoint is busy or fails [s]
_LONGEST_PAUSE = 60.0  # if the endpoint says how long [s]
_FOR_NOW = (429, 500, 502, 503, 504)  # HTTP statuses that may pass by themselves
_NOT_SO = (400, 415, 422, 501)  # HTTP statuses of a request that the endpoint does not take
_HERE = ("127.0.0.1", "::1", "localhost")

Message: TypeAlias = Mapping[str, str]  # `role` and `content`


class EndpointError(UserError):
    """The endpoint cannot be used."""


@dataclass
class Endpoint:
    """Where a model is asked; redirections are not followed, as they would take the key along."""

    url: str  # without `/chat/completions`
    model: str
    key: str = ""
    patience: float = 120.0  # for a whole answer [s]
    keeps_to_schema: bool = True  # as long as it has not refused one

    def answer(self, messages: Sequence[Message], schema: Mapping[str, Any]) -> str:
        """The text that the model answers, asked to keep to a JSON schema; raises EndpointError."""
        form = {"name": "answer", "strict": True, "schema": schema}
        kept_to = {"type": "json_schema", "json_schema": form}
        asked: dict[str, object] = {"model": self.model, "messages": messages}
        try:
            if self.keeps_to_schema:
                status, body = self._patiently(asked | {"response_format": kept_to})
                self.keeps_to_schema = status not in _NOT_SO
            if not self.keeps_to_schema:
                status, body = self._patiently(asked)
        except (OSError, HTTPException, ValueError) as error:
            raise self._error(str(error) or "it did not answer in time") from None
        if status != 200:
            told = visible(body[:200].decode(errors="replace"))
            tried = f"at each of {len(_PAUSES) + 1} tries" if status in _FOR_NOW else ""
            hint = tried or "look at URL, model and key"
            raise self._error(f"HTTP status {status}; {hint}: {told}")
        try:
            message = json.loads(body)["choices"][0]["message"]
            text = message.get("content") or json.dumps(
                {"task": "", "cannot": str(message["refusal"])}
            )
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
            raise self._error("it does not answer as an OpenAI-compatible one does") from None
        return str(text)

    def _patiently(self, asked: Mapping[str, object]) -> tuple[int, bytes]:
        """Status and body of the reply; where it may be another one soon, of a later one."""
        for pause in (*_PAUSES, None):
            status, body, after = self._post(json.dumps(asked).encode())
            if status not in _FOR_NOW or pause is None:
                break
            wanted = float(after) if after.isdecimal() else pause
            time.sleep(min(wanted, _LONGEST_PAUSE))
        return status, body

    def _post(self, body: bytes) -> tuple[int, bytes, str]:
        """Status, body and `Retry-After` of the reply; the connection is cut after `patience`."""
        at = urlsplit(self.url)
        if at.scheme not in ("http", "https") or not at.hostname:
            raise self._error("is no URL; give one as http://127.0.0.1:8080/v1")
        if self.key and at.scheme == "http" and at.hostname not in _HERE:
            raise self._error("the key would be sent openly; use https")
        kind = HTTPSConnection if at.scheme == "https" else HTTPConnection
        connection = kind(at.hostname, at.port, timeout=self.patience)
        connection.connect()
        opened = connection.sock  # which the connection forgets with the last bytes

        late = Event()

        def cut() -> None:
            late.set()
            with suppress(OSError):
                opened.shutdown(socket.SHUT_RDWR)

        timer = Timer(self.patience, cut)
        timer.start()
        try:
            headers = {"Content-Type": "application/json"}
            headers |= {"Authorization": f"Bearer {self.key}"} if self.key else {}
            connection.request("POST", f"{at.path.rstrip('/')}/chat/completions", body, headers)
            response = connection.getresponse()
            answer = response.read(_LONGEST + 1)
        finally:
            timer.cancel()
            connection.close()
        if late.is_set():
            raise TimeoutError
        if len(answer) > _LONGEST:
            raise self._error(f"its answer is longer than {_LONGEST} bytes")
        return response.status, answer, response.getheader("Retry-After", "").strip()

    def _error(self, why: str) -> EndpointError:
        return EndpointError(f"{visible(self.url)}: {' '.join(why.split())}")
