"""A language model behind an OpenAI-compatible endpoint."""

from __future__ import annotations

import json
import socket
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
_HERE = ("127.0.0.1", "::1", "localhost")

Message: TypeAlias = Mapping[str, str]  # `role` and `content`


class EndpointError(UserError):
    """The endpoint cannot be used."""


@dataclass(frozen=True)
class Endpoint:
    """Where a model is asked; redirections are not followed, as they would take the key along."""

    url: str  # without `/chat/completions`
    model: str
    key: str = ""
    patience: float = 120.0  # for a whole answer [s]

    def answer(self, messages: Sequence[Message], schema: Mapping[str, Any]) -> str:
        """The text that the model answers, asked to keep to a JSON schema; raises EndpointError."""
        form = {"name": "answer", "strict": True, "schema": schema}
        kept_to = {"type": "json_schema", "json_schema": form}
        asked = {"model": self.model, "messages": messages, "response_format": kept_to}
        try:
            status, body = self._post(json.dumps(asked).encode())
        except (OSError, HTTPException, ValueError) as error:
            raise self._error(str(error) or "it did not answer in time") from None
        if status != 200:
            told = visible(body[:200].decode(errors="replace"))
            raise self._error(f"HTTP status {status}; look at URL, model and key: {told}")
        try:
            message = json.loads(body)["choices"][0]["message"]
            text = message.get("content") or json.dumps(
                {"task": "", "cannot": str(message["refusal"])}
            )
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
            raise self._error("it does not answer as an OpenAI-compatible one does") from None
        return str(text)

    def _post(self, body: bytes) -> tuple[int, bytes]:
        """Status and body of the reply; the connection is cut when it takes too long."""
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
        return response.status, answer

    def _error(self, why: str) -> EndpointError:
        return EndpointError(f"{visible(self.url)}: {' '.join(why.split())}")
