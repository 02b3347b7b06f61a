"""Weights files: reading them safely.

Weights are safetensors files, or state dicts that PyTorch saved with the published parameter names;
pickled modules contain code and are refused.
"""

import json
import pickle
import warnings
from collections.abc import Mapping
from os.path import isfile
from pathlib import Path
from typing import TypeAlias

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import load_file

from config import extra
from config.arrays import Image
from perception.grasps.network_input import WeightsError

Weights: TypeAlias = Mapping[str, Image]  # the tensors of a network by their names in PyTorch

SHIPPED = Path(__file__).parents[1] / "weights"
LARGEST_WEIGHT = 1e4  # of a trained network; shipped weights stay below 100


def read_weights(path: Path, kind: str) -> Weights:
    """The weights in a file.

    Args:
        path: the file.
        kind: `ggcnn` or `hold`, the shipped weights whose names and shapes it must have.

    Raises:
        WeightsError: the file is missing, unreadable, of another network, or holds implausible
            numbers.
    """
    expected, given = load_file(SHIPPED / f"{kind}.safetensors"), _read(path)
    if given.keys() != expected.keys():
        raise WeightsError(f"{path}: these tensors are not those of `{kind}`; give weights of one")
    for name, value in expected.items():
        if problem := _problem(given[name], value):
            hint = f"give weights that were trained for `{kind}`"
            raise WeightsError(f"{path}: tensor `{name}` {problem}; {hint}")
    return {name: np.asarray(value, dtype=np.float32) for name, value in given.items()}


def _problem(given: Image, expected: Image) -> str:
    """Why a tensor cannot replace another; empty if it can."""
    if given.shape != expected.shape:
        return f"has shape {given.shape}, not {expected.shape}"
    if given.dtype.kind != expected.dtype.kind:
        return f"has numbers of type {given.dtype}, not {expected.dtype}"
    if not bool(np.isfinite(given).all()):
        return "has numbers that are not finite"
    if given.dtype.kind == "f" and bool((np.abs(given) > LARGEST_WEIGHT).any()):
        return f"has numbers beyond {LARGEST_WEIGHT:g}, out of all reason"
    return ""


def _read(path: Path) -> Weights:
    if not isfile(path):
        raise WeightsError(f"{path}: no such weights file; give the path of a .safetensors file")
    try:
        return load_file(path) if path.suffix == ".safetensors" else _state_dict(path)
    except WeightsError:
        raise
    except pickle.UnpicklingError as error:
        raise WeightsError(
            f"{path}: contains pickled code, which is never run; save only its state_dict()"
        ) from error
    except Exception as error:  # of a parser of files that anybody may have made
        raise _unreadable(path, error) from error


def _state_dict(path: Path) -> Weights:
    """The tensors of a state dict of PyTorch.

    Raises:
        WeightsError: PyTorch is missing, or the file contains something else.
    """
    try:
        import torch  # an extra, which takes a second to import
    except ImportError:
        raise WeightsError(f"{path}: a file of PyTorch needs {extra('training')}") from None
    with warnings.catch_warnings(action="ignore"):  # such files are refused
        state = torch.load(path, map_location="cpu", weights_only=True)
    if not isinstance(state, dict) or not all(torch.is_tensor(each) for each in state.values()):
        raise WeightsError(f"{path}: not a state_dict; save the network's state_dict() instead")
    return {name: value.numpy(force=True) for name, value in state.items()}


def _unreadable(path: Path, error: Exception) -> WeightsError:
    why = " ".join(str(error).split())[:100]
    return WeightsError(f"{path}: not a readable weights file ({why}); train or download it again")


def read_metadata(path: Path) -> dict[str, object]:
    """The metadata of a weights file; empty if it is not a safetensors file.

    Raises:
        WeightsError: it cannot be read.
    """
    if path.suffix != ".safetensors":
        return {}
    try:
        with safe_open(path, framework="np") as file:
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
