"""Files of weights: which network they are for, reading them safely, writing them with their story.

Weights are safetensors files, or state dicts that PyTorch saved under the published names; pickled
modules hold code and are refused. The tensors themselves tell which network they belong to.
"""

from __future__ import annotations

import json
import pickle
import warnings
from collections.abc import Mapping
from importlib.resources import as_file, files
from pathlib import Path
from typing import TypeAlias

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save_file
from torch import Tensor

from perception.angle_bins import AngleBinNetwork
from perception.ggcnn import GGCNN, GGCNN2
from perception.maps import WeightsError

Network: TypeAlias = AngleBinNetwork | GGCNN | GGCNN2

NETWORKS: dict[str, type[Network]] = {"bins": AngleBinNetwork, "ggcnn": GGCNN, "ggcnn2": GGCNN2}
"""Every network that proposes grasps, by what `--network` calls it."""
SHIPPED = ("bins", "ggcnn")
"""Those that come with weights; the first is the default."""


def shipped_network(name: str = SHIPPED[0]) -> Network:
    """A network with the weights that come with the package.

    Raises:
        WeightsError: none come for this name.
    """
    if name not in SHIPPED:
        known = ", ".join(f"`{each}`" for each in SHIPPED)
        raise WeightsError(f"no weights are shipped for a network `{name}`: name one of {known}")
    with as_file(files("perception") / "weights" / f"{name}.safetensors") as path:
        return load_network(path)


def load_network(path: Path) -> Network:
    """The network that the weights of a file belong to, with those weights.

    Args:
        path: a safetensors file, or a state dict saved by PyTorch under the published names.

    Raises:
        WeightsError: there is no such file, or it does not hold weights of a known network.
    """
    state = _read(path)
    for make in NETWORKS.values():
        network = make()
        if network.state_dict().keys() == state.keys():
            break
    else:
        kinds = ", ".join(f"`{name}`" for name in NETWORKS)
        raise WeightsError(
            f"{path}: these tensors belong to none of the networks {kinds}; give weights that were "
            "trained for one of them"
        )
    for name, value in network.state_dict().items():
        if value.shape != state[name].shape:
            raise WeightsError(
                f"{path}: tensor `{name}` has shape {tuple(state[name].shape)}, not "
                f"{tuple(value.shape)}; give weights that were trained for {make.__name__}"
            )
        if not bool(torch.isfinite(state[name]).all()):
            raise WeightsError(f"{path}: some weights are not finite; train or download them again")
    network.load_state_dict(state)
    return network.float().eval()


def name_of(network: Network) -> str:
    """What `--network` calls it."""
    return next(name for name, kind in NETWORKS.items() if isinstance(network, kind))


def _read(path: Path) -> dict[str, Tensor]:
    if not path.is_file():
        raise WeightsError(f"{path}: no such weights file; give the path of a .safetensors file")
    if path.suffix == ".safetensors":
        try:
            return load_file(path)
        except (SafetensorError, OSError) as error:
            raise WeightsError(
                f"{path}: not a readable safetensors file ({error}); train or download it again"
            ) from error
    try:
        with warnings.catch_warnings(action="ignore"):  # about what is refused just below
            state = torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise WeightsError(
            f"{path}: holds pickled code, which is never run; save only its state_dict() and "
            "give that file"
        ) from error
    except (RuntimeError, OSError, EOFError, ValueError, KeyError) as error:
        raise WeightsError(
            f"{path}: not a file of weights; give a .safetensors file or a saved state_dict()"
        ) from error
    if not isinstance(state, dict) or not all(isinstance(v, Tensor) for v in state.values()):
        raise WeightsError(f"{path}: not a state_dict; save the network's state_dict() instead")
    return state


def save_network(network: Network, path: Path, story: Mapping[str, object]) -> None:
    """Write the weights as safetensors, with what is to be known about them (as JSON)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    state = {name: value.detach().contiguous() for name, value in network.state_dict().items()}
    save_file(state, path, metadata={key: json.dumps(value) for key, value in story.items()})
    path.chmod(0o644)  # safetensors leaves it to its owner alone


def read_story(path: Path) -> dict[str, object]:
    """What `save_network` wrote beside the weights; of weights from elsewhere what they say."""
    if path.suffix != ".safetensors":
        return {}
    with safe_open(path, framework="pt") as file:
        metadata = file.metadata() or {}
    story: dict[str, object] = {}
    for key, text in metadata.items():
        try:
            story[key] = json.loads(text)
        except json.JSONDecodeError:
            story[key] = text
    return story
