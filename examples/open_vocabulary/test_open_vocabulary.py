"""The encoder is a stand-in whose feature is the mean colour, as ONNX and from torch.export."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from open_vocabulary import FOLDER, OpenVocabulary

COLOURS = {"tomato": (1.0, 0.1, 0.1), "lime": (0.1, 1.0, 0.1), "_table": (0.6, 0.6, 0.6)}


def part(number: int, *content: bytes) -> bytes:
    """A field of a protocol buffer; shorter than 128 bytes."""
    return bytes([number << 3 | 2, sum(map(len, content))]) + b"".join(content)


def value(name: bytes, *shape: int) -> bytes:
    sides = part(2, *(part(1, b"\x08" + (bytes([one & 127 | 128, one >> 7]))) for one in shape))
    return part(1, name) + part(2, part(1, b"\x08\x01", sides))


def onnx() -> bytes:
    """A model of one node."""
    node = part(1, b"x") + part(2, b"y") + part(4, b"GlobalAveragePool")
    ends = part(11, value(b"x", 1, 3, 224, 224)), part(12, value(b"y", 1, 3, 1, 1))
    return b"\x08\x08" + part(7, part(1, node), part(2, b"g"), *ends) + part(8, b"\x10\x0d")


@pytest.mark.parametrize("kind", ["onnx", "pt2"])
def test_a_word_is_the_one_that_looks_most_alike(tmp_path, monkeypatch, kind):
    monkeypatch.setenv(FOLDER, str(tmp_path))
    np.savez(tmp_path / "words.npz", **{word: np.array(c) for word, c in COLOURS.items()})
    (tmp_path / "encoder.onnx").write_bytes(onnx())
    if kind == "pt2":
        (tmp_path / "encoder.onnx").unlink()
        network = torch.nn.AdaptiveAvgPool2d(1)
        exported = torch.export.export(network, (torch.zeros(1, 3, 224, 224),))
        torch.export.save(exported, tmp_path / "encoder.pt2")
    colour = np.full((60, 90, 3), 150, dtype=np.uint8)
    colour[10:30, 10:30], colour[10:30, 50:70] = (200, 20, 30), (20, 190, 20)
    boxes = [(10, 10, 29, 29), (50, 10, 69, 29), (30, 40, 49, 55)]
    found = OpenVocabulary()
    assert found.kinds == ("tomato", "lime")
    seen = [SimpleNamespace(box=box) for box in boxes]
    labels = found.recognise(SimpleNamespace(colour=colour), seen)
    assert [(one.kind, one.box) for one in labels] == [("tomato", boxes[0]), ("lime", boxes[1])]
    assert found.recognise(SimpleNamespace(colour=None), seen) == []
