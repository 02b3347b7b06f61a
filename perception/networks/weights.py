"""Weights files: reading them safely, and writing them with metadata.

Weights are safetensors files, or state dicts that PyTorch saved with the published parameter names;
pickled modules contain code and are refused.
"""

import json
import pickle
import warnings
from collections.abc import Mapping
from importlib.resources import as_file, files
from os.path import isfile
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from perception.grasps.network_input import WeightsError
from perception.networks.ggcnn import GGCNN

LARGEST_WEIGHT = 1e4  # of a trained network; shipped weights stay below 100
_LARGEST_OUTPUT = 1e6  # on a plain image; trained networks answer about 1


def shipped_network() -> GGCNN:
    """GG-CNN with its shipped weights."""
    with as_file(files("perception") / "weights" / "ggcnn.safetensors") as path:
        return load_network(path)


def load_network(path: Path) -> GGCNN:
    """GG-CNN with the weights of a file.

    Raises:
        WeightsError: the file is missing, unreadable, of another network, or holds implausible
            numbers.
    """
    network = GGCNN()
    network.load_state_dict(read_state(path, network))
    network = network.float().eval()
    with torch.inference_mode():
        answer = network(_plain_image())
    if not bool((answer.abs() < _LARGEST_OUTPUT).all()):
        raise WeightsError(f"{path}: the network answers implausible numbers; train it again")
    return network


def read_state(path: Path, network: nn.Module) -> dict[str, Tensor]:
    """The tensors of a weights file for a network.

    Raises:
        WeightsError: the file is missing, unreadable, of another network, or holds implausible
            numbers.
    """
    state = _read(path)
    if state.keys() != network.state_dict().keys():
        kind = type(network).__name__
        raise WeightsError(f"{path}: these tensors are not those of {kind}; give weights of one")
    for name, value in network.state_dict().items():
        if problem := _problem(state[name], value):
            hint = f"give weights that were trained for {type(network).__name__}"
            raise WeightsError(f"{path}: tensor `{name}` {problem}; {hint}")
    return state


def _problem(given: Tensor, expected: Tensor) -> str:
    """Why a tensor cannot replace another; empty if it can."""
    if given.layout is not torch.strided or given.is_quantized or given.device.type != "cpu":
        return "is not a plain array of numbers"
    if given.shape != expected.shape:
        return f"has shape {tuple(given.shape)}, not {tuple(expected.shape)}"
    if given.is_floating_point() != expected.is_floating_point() or given.dtype is torch.bool:
        return f"has numbers of type {given.dtype}, not {expected.dtype}"
    if not bool(torch.isfinite(given).all()):
        return "has numbers that are not finite"
    if given.is_floating_point() and bool((given.abs() > LARGEST_WEIGHT).any()):
        return f"has numbers beyond {LARGEST_WEIGHT:g}, out of all reason"
    return ""


def _plain_image() -> Tensor:
    """A smooth depth image, small because the networks take every size: (1, 1, 60, 60)."""
    slope = torch.linspace(-0.3, 0.3, 60)
    return (slope[:, None] + slope[None, :])[None, None]


def _read(path: Path) -> dict[str, Tensor]:
    if not isfile(path):
        raise WeightsError(f"{path}: no such weights file; give the path of a .safetensors file")
    try:
        if path.suffix == ".safetensors":
            return load_file(path)
        with warnings.catch_warnings(action="ignore"):  # such files are refused below
            state = torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise WeightsError(
            f"{path}: contains pickled code, which is never run; save only its state_dict()"
        ) from error
    except Exception as error:  # of a parser of files that anybody may have made
        raise _unreadable(path, error) from error
    if not isinstance(state, dict) or not all(isinstance(v, Tensor) for v in state.values()):
        raise WeightsError(f"{path}: not a state_dict; save the network's state_dict() instead")
    return state


def _unreadable(path: Path, error: Exception) -> WeightsError:
    why = " ".join(str(error).split())[:100]
    return WeightsError(f"{path}: not a readable weights file ({why}); train or download it again")


def save_network(network: nn.Module, path: Path, metadata: Mapping[str, object]) -> None:
    """Write weights as safetensors with metadata, whose values are stored as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    state = {name: value.detach().contiguous() for name, value in network.state_dict().items()}
    save_file(state, path, metadata={key: json.dumps(value) for key, value in metadata.items()})
    path.chmod(0o644)  # safetensors makes it readable by its owner only


def read_metadata(path: Path) -> dict[str, object]:
    """The metadata of a weights file; empty if it is not a safetensors file.

    Raises:
        WeightsError: it cannot be read.
    """
    if path.suffix != ".safetensors":
        return {}
    try:
        with safe_open(path, framework="pt") as file:
            texts = file.metadata() or {}
    except (SafetensorError, OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    metadata: dict[str, object] = {}
    for key, text in texts.items():
        try:
            metadata[key] = json.loads(text)
        except (ValueError, RecursionError):  # other tools store plain text
            metadata[key] = text
    return metadata
