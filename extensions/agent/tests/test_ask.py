"""`frankie-task ask` with a scripted endpoint behind a real socket."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import pytest
from command_line import call

from config import UserError
from extensions.agent.tools import Tools

TASK = "task: hello\nscene: single\ntree: {say: {text: Hello.}}\n"


class Script(ThreadingHTTPServer):
    """Answers a model's texts in turn, the last one again and again; or bytes as they are."""

    daemon_threads = True

    def __init__(self, *answers: object) -> None:
        super().__init__(("127.0.0.1", 0), Speaker)
        self.answers, self.asked = list(answers), []

    @property
    def options(self) -> tuple[str, ...]:
        return "--url", f"http://127.0.0.1:{self.server_port}/v1", "--model", "scripted"


class Speaker(BaseHTTPRequestHandler):
    server: Script

    def do_POST(self) -> None:
        script = self.server
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        script.asked.append((self.path, dict(self.headers), body))
        answer = script.answers.pop(0) if len(script.answers) > 1 else script.answers[0]
        if isinstance(answer, bytes):
            self.wfile.write(answer)
        elif answer is None:  # a byte now and then, for ever
            self.wfile.write(b"HTTP/1.0 200 OK\r\n\r\n")
            with suppress(BrokenPipeError, ConnectionResetError):
                while True:
                    self.wfile.write(b" ")
                    time.sleep(0.1)
        else:
            text = answer if isinstance(answer, str) else json.dumps(answer)
            said = json.dumps({"choices": [{"message": {"content": text}}]})
            self.wfile.write(b"HTTP/1.0 200 OK\r\n\r\n" + said.encode())

    def log_message(self, *_: object) -> None:
        pass


@contextmanager
def endpoint(*answers: object) -> Iterator[Script]:
    with Script(*answers) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENAI_API_KEY", "sesame")
    return tmp_path


@pytest.mark.parametrize(
    ("typed", "code"), [("y\n", 0), pytest.param("\n", 1, marks=pytest.mark.slow)]
)
def test_a_draft_is_repaired_simulated_shown_and_kept_by_a_person(folder, typed, code):
    drafts = ("I think ...", {"task": TASK.replace("say", "speak"), "cannot": "I cannot wave."})
    with endpoint(*drafts) as script:
        done = call("ask", "Say hello!", *script.options, typed=typed)
    assert done[0] == code, done
    assert (folder / "proposed_say_hello.yaml").is_file() is (code == 0)
    for told in ("I cannot wave.", "nearest", "say", "hello, dry: success", "view --web runs"):
        assert told in done[1]
    [(path, headers, first), (_, _, second)] = script.asked
    assert (path, headers["Authorization"]) == ("/v1/chat/completions", "Bearer sesame")
    assert first["response_format"]["json_schema"]["schema"]["required"] == ["task", "cannot"]
    assert "one JSON object" in second["messages"][-1]["content"]
    [newest] = folder.glob("runs/*-hello/transcript.json")
    said = json.loads(newest.read_text())
    assert [one["role"] for one in said] == [
        *("system", "user", "assistant", "user", "assistant", "user")
    ]
    change = "line 3: `tree: {speak: {text: Hello.}}` is now `tree: {say: {text: Hello.}}`"
    assert change in said[-1]["content"]
    assert change in done[2]
    assert "sesame" not in newest.read_text()


def answered(*answers: object, rounds: int = 1) -> tuple[int, str, str, list]:
    """What `ask` says of a model's answers, and what the model was asked."""
    with endpoint(*answers) as script:
        done = call("ask", "Do it", *script.options, "--rounds", rounds, typed="y\n")
    return *done, script.asked


def test_what_cannot_be_done_is_said_in_one_line(folder):
    code, out, _, asked = answered({"task": "", "cannot": "No.\n\n✔ kept as ok.yaml\x1b[2J"})
    assert (code, len(asked)) == (1, 1)
    assert out == "It cannot be done: No. ✔ kept as ok.yaml\\x1b[2J\n"
    assert "kept as ok" in (folder / "runs/transcript.json").read_text()


BUSY = b"HTTP/1.0 429 Busy\r\nRetry-After: 0\r\n\r\nlater"
FAILED = b"HTTP/1.0 500 No\r\nRetry-After: 0\r\n\r\n"
NO_SCHEMA = b"HTTP/1.0 400 No\r\n\r\nresponse_format is not supported"


def test_an_endpoint_may_be_busy_fail_for_now_and_know_no_schemas():
    refusal = {"task": None, "cannot": "No.", "thoughts": "{"}
    code, out, _, asked = answered(BUSY, FAILED, NO_SCHEMA, FAILED, refusal)
    assert (code, out) == (1, "It cannot be done: No.\n")
    assert ["response_format" in body for _, _, body in asked] == [True, True, True, False, False]
    code, _, err, asked = answered(BUSY)
    assert (code, len(asked)) == (2, 4)
    assert "HTTP status 429; at each of 4 tries: later" in err


@pytest.mark.parametrize(
    "answer",
    [
        f"Here it is:\n```yaml\n{TASK}```\nGood luck {{}}!",
        TASK,
        f"I use {{say}}:\n```json\n{json.dumps({'task': TASK, 'cannot': None, 'why': 1})}\n```",
    ],
)
def test_an_answer_is_read_in_other_forms(answer, monkeypatch):
    kept = {}

    async def simulated(self, task, **given):
        kept["task"] = task
        raise UserError("seen")

    monkeypatch.setattr(Tools, "simulate", simulated)
    answered(answer)
    assert kept["task"].strip() == TASK.strip()


def test_the_model_hears_what_is_wrong_with_its_answer_and_the_person_plain_words():
    wrong = TASK.replace("say:", "open_drawer:")
    code, out, _, asked = answered([1], {"task": {"tree": 1}}, {"task": wrong}, rounds=3)
    heard = [body["messages"][-1]["content"] for _, _, body in asked[1:]]
    assert heard[0].startswith("there is no JSON object in your answer; answer with one")
    assert heard[1] == "`task` of your answer is a dict; write it as one text"
    assert code == 1
    assert out.startswith(
        "3 rounds brought no task that works; the last: it has errors, in the scene"
    )
    assert "unknown node `open_drawer`" in out
    assert not set('{"') & set(out)


@pytest.mark.parametrize(
    ("task", "told"),
    [
        ("task: t\ntree: {subtree: {file: ../secret.yaml}}", "leads out of the folder"),
        ("task: t\nrobot: real\ntree: {say: {text: x}}", "has no key `robot`"),
        (TASK.replace("say: {text: Hello.}", "near: {pose: up}, force: failure"), "up"),
        pytest.param(
            TASK.replace("{say", "{force: failure, say"),
            "in simulation: force_failure failed",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_model_that_does_not_give_in_is_given_up(folder, task, told):
    code, out, _, asked = answered({"task": task, "cannot": ""}, rounds=3)
    assert (code, len(asked)) == (1, 3)
    assert "3 rounds brought no task that works" in out
    assert told in asked[1][2]["messages"][-1]["content"]
    assert not list(folder.glob("proposed_*"))


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (None, "it did not answer in time"),
        (b"HTTP/1.0 302 Found\r\nLocation: http://127.0.0.1:9/\r\n\r\n", "HTTP status 302"),
        (b"HTTP/1.0 401 No\r\n\r\n\x1b[2Jwrong key", "HTTP status 401; look at URL, model and key"),
        (b"HTTP/1.0 200 OK\r\n\r\n" + b" " * 1_100_000, "longer than 1000000 bytes"),
        (b"HTTP/1.0 200 OK\r\n\r\n[]", "as an OpenAI-compatible one does"),
        (b"nonsense", "127.0.0.1"),
    ],
)
def test_a_bad_endpoint_is_one_line(answer, told):
    with endpoint(answer) as script:
        code, _, err = call("ask", "Do it", *script.options, "--patience", 2)
    assert code == 2
    assert told in err.splitlines()[-1]
    assert "\x1b" not in err


def test_the_key_goes_to_no_one_else():
    for url, told in (("http://models.example/v1", "use https"), ("models", "is no URL")):
        code, _, err = call("ask", "Do it", "--url", url, "--model", "x")
        assert (code, told in err) == (2, True)
