"""Hostile weights files: each is refused in one line, and no code in them runs."""

import pickle
import struct
from pathlib import Path

import pytest
import torch
from bomb import Bomb
from safetensors.torch import load_file, save_file

from perception.grasps.network_input import WeightsError
from perception.networks.weights import load_network

SHIPPED = Path("perception/weights")


def tensors(change):
    """A file of the shipped weights, with some changed."""

    def make(path: Path) -> None:
        state = load_file(SHIPPED / "ggcnn.safetensors")
        name = next(key for key, value in state.items() if value.is_floating_point())
        (save_file if path.suffix == ".safetensors" else torch.save)(change(state, name), path)

    return make


def data(change):
    return lambda path: path.write_bytes(change((SHIPPED / "ggcnn.safetensors").read_bytes()))


def every(value: float):
    return tensors(
        lambda state, _: {
            key: torch.full_like(one, value) if one.is_floating_point() else one
            for key, one in state.items()
        }
    )


def one(make):
    return lambda state, name: state | {name: make(state[name])}


HOSTILE = {
    "all 1e38": ("s", every(1e38)),
    "all 9999, which no answer survives": ("s", every(9999.0)),
    "one that is no number": ("s", tensors(one(lambda v: torch.full_like(v, torch.nan)))),
    "another shape": ("s", tensors(one(lambda v: torch.zeros(3)))),
    "one missing": ("s", tensors(lambda s, name: {k: v for k, v in s.items() if k != name})),
    "truncated": ("s", data(lambda b: b[:5000])),
    "a header of 2^63": ("s", data(lambda b: struct.pack("<Q", 2**63) + b[8:])),
    "pickled code": ("p", lambda path: path.write_bytes(pickle.dumps(Bomb(path.parent / "ran")))),
    "code of PyTorch": ("p", lambda path: torch.save(Bomb(path.parent / "ran"), path)),
    "a list": ("p", lambda path: torch.save([], path)),
    "a sparse tensor": ("p", tensors(one(lambda v: v.to_sparse()))),
    "a tensor without data": ("p", tensors(one(lambda v: v.to("meta")))),
    "a folder": ("p", Path.mkdir),
    "nothing": ("s", lambda path: None),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_weights_are_refused_in_one_line(kind, tmp_path):
    form, make = HOSTILE[kind]
    path = tmp_path / {"s": "w.safetensors", "p": "w.pt"}[form]
    make(path)
    with pytest.raises(WeightsError) as error:
        load_network(path)
    text = str(error.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    assert "; " in text
    assert len(text) < 500
    assert not (tmp_path / "ran").exists()
