"""The networks are the published ones, fast forms equal them, and weights survive a file."""

from pathlib import Path

import numpy as np
import pytest
import torch

from perception.networks.ggcnn import GGCNN, evaluate, subpixel_form
from perception.networks.weights import load_network, read_metadata, save_network, shipped_network

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


@pytest.mark.parametrize("cells", [False, True])
def test_the_fast_forms_equal_the_published_one(network: GGCNN, cells: bool) -> None:
    image = torch.from_numpy(np.random.default_rng(0).normal(0.0, 0.2, (1, 1, 300, 300))).float()
    with torch.inference_mode():
        plain = network(image)
        fast = evaluate(subpixel_form(network, cells=cells), image)
    plain = plain[..., 1::3, 1::3] if cells else plain
    assert (fast - plain).abs().max() < 2e-5 * max(1.0, float(plain.abs().max()))


def test_weights_survive_a_file(network: GGCNN, tmp_path: Path) -> None:
    path = tmp_path / "w.safetensors"
    save_network(network, path, {"data": {"images": 10}})
    loaded = load_network(path)
    for tensor, value in network.state_dict().items():
        assert torch.equal(value, loaded.state_dict()[tensor])
    assert read_metadata(path) == {"data": {"images": 10}}


def test_a_published_style_state_dict_loads(network: GGCNN, tmp_path: Path) -> None:
    path = tmp_path / "published_statedict.pt"
    torch.save(network.state_dict(), path)
    assert torch.equal(load_network(path).conv1.weight, network.conv1.weight)
    assert read_metadata(path) == {}


def test_shipped_weights_load_and_know_how_they_were_made() -> None:
    shipped_network()
    metadata = read_metadata(Path("perception/weights/ggcnn.safetensors"))
    assert metadata["recipe"]["data"]["images"] == 16384
