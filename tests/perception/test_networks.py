"""The networks are the published ones, fast forms equal them, and weights survive a file."""

from pathlib import Path

import numpy as np
import pytest
import torch

from perception.networks.ggcnn import GGCNN
from perception.networks.proposer import Proposer
from perception.networks.weights import (
    NETWORKS,
    load_network,
    network_name,
    read_metadata,
    save_network,
    shipped_network,
)

PUBLISHED = {
    "conv1": (32, 1, 9, 9),
    "conv2": (16, 32, 5, 5),
    "conv3": (8, 16, 3, 3),
    "convt1": (8, 8, 3, 3),
    "convt2": (8, 16, 5, 5),
    "convt3": (16, 32, 9, 9),
    "pos_output": (1, 32, 2, 2),
    "cos_output": (1, 32, 2, 2),
    "sin_output": (1, 32, 2, 2),
    "width_output": (1, 32, 2, 2),
}


@pytest.fixture(scope="module")
def network() -> GGCNN:
    torch.manual_seed(3)
    return GGCNN().eval()


def test_layers_and_names_are_the_published_ones(network: GGCNN) -> None:
    shapes = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    weights = {name.removesuffix(".weight"): s for name, s in shapes.items() if "weight" in name}
    assert weights == PUBLISHED
    assert set(shapes) == {f"{n}.{kind}" for n in PUBLISHED for kind in ("weight", "bias")}
    assert sum(p.numel() for p in network.parameters()) == 62_420
    with torch.inference_mode():
        assert network(torch.zeros(1, 1, 300, 300)).shape == (1, 4, 300, 300)


@pytest.mark.parametrize("name", NETWORKS)
def test_the_fast_form_equals_the_plain_one(name: str) -> None:
    torch.manual_seed(1)
    network = NETWORKS[name]()
    for module in network.modules():  # batch norms that have seen something
        if isinstance(module, torch.nn.BatchNorm2d):
            torch.nn.init.uniform_(module.running_mean, -0.1, 0.1)
            torch.nn.init.uniform_(module.running_var, 0.5, 2.0)
    image = np.random.default_rng(0).normal(0.0, 0.2, (300, 300)).astype(np.float32)
    plain = Proposer(network, plain=True).infer(image)
    fast = Proposer(network).infer(image)
    assert np.abs(fast - plain).max() < 2e-5 * max(1.0, np.abs(plain).max())


@pytest.mark.parametrize("name", NETWORKS)
def test_weights_survive_a_file_and_tell_their_network(name: str, tmp_path: Path) -> None:
    path = tmp_path / "w.safetensors"
    network = NETWORKS[name]()
    save_network(network, path, {"data": {"images": 10}})
    loaded = load_network(path)
    assert network_name(loaded) == name
    for tensor, value in network.state_dict().items():
        assert torch.equal(value, loaded.state_dict()[tensor])
    assert read_metadata(path) == {"data": {"images": 10}}


def test_a_published_style_state_dict_loads(network: GGCNN, tmp_path: Path) -> None:
    path = tmp_path / "published_statedict.pt"
    torch.save(network.state_dict(), path)
    loaded = load_network(path)
    assert isinstance(loaded, GGCNN)
    assert torch.equal(loaded.conv1.weight, network.conv1.weight)
    assert read_metadata(path) == {}


@pytest.mark.parametrize("name", NETWORKS)
def test_shipped_weights_load_and_know_how_they_were_made(name: str) -> None:
    assert network_name(shipped_network(name)) == name
    metadata = read_metadata(Path("perception/weights") / f"{name}.safetensors")
    assert metadata["recipe"]["network"] == name
    assert metadata["valid_of_unseen"]["single"] > 0.8
