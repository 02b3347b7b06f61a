"""The networks are the published ones, hostile weights are refused, and points without any."""

import pickle
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from bomb import Bomb
from safetensors.torch import load_file, save_file

from lab.grasps.choice import RandomPoints
from lab.grasps.torch_networks import GGCNN, HoldNetwork, as_tensors, save_network
from perception.grasps.candidates import SpreadPoints
from perception.grasps.network_input import WeightsError
from perception.networks.ggcnn import load_ggcnn
from perception.networks.hold import HOLD_NUMBERS, HoldInputs
from perception.networks.hold import HoldNetwork as HoldInference
from perception.networks.weights import read_metadata, read_weights

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


def test_the_fast_forms_equal_the_published_one(network: GGCNN, tmp_path: Path) -> None:
    image = np.random.default_rng(0).normal(0.0, 0.2, (300, 300)).astype(np.float32)
    with torch.inference_mode():
        plain, fast = (
            form(torch.from_numpy(image)[None, None])[0].numpy()
            for form in (network, network.in_subpixels)
        )
    tolerance = 2e-5 * max(1.0, float(np.abs(plain).max()))
    assert np.abs(fast - plain).max() < tolerance
    save_network(network, tmp_path / "w.safetensors", {})
    inference, wanted = load_ggcnn(tmp_path / "w.safetensors"), np.zeros((100, 100), dtype=bool)
    wanted[3:40, 60:100] = True
    for part in (np.ones((100, 100), dtype=bool), wanted):
        maps = inference.infer(image, part)
        assert np.abs(maps - plain[:, 1::3, 1::3])[:, part].max() < tolerance


def test_the_hold_network_infers_what_was_trained(tmp_path: Path) -> None:
    torch.manual_seed(5)
    rng, network = np.random.default_rng(1), HoldNetwork()
    shapes = (32, 48, 3), (32, 32, 3), (HOLD_NUMBERS,)
    inputs = [rng.normal(0.0, 1.0, (32, *shape)).astype(np.float32) for shape in shapes]
    network.train()(*as_tensors(HoldInputs(*inputs)))  # the batch norms learn means and variances
    save_network(network.eval(), tmp_path / "h.safetensors", {})
    inference = HoldInference(read_weights(tmp_path / "h.safetensors", "hold"))
    for count in (1, 7, 7):  # the memory of a call is used again
        some = HoldInputs(*(each[-count:] for each in inputs))
        with torch.inference_mode():
            likely = network(*as_tensors(some)).sigmoid().numpy()
        assert inference(some) == pytest.approx(likely, abs=1e-6)


def test_weights_survive_a_file_and_those_of_a_published_style_load(network, tmp_path):
    path, published = tmp_path / "w.safetensors", tmp_path / "published_statedict.pt"
    save_network(network, path, {"data": {"images": 10}})
    torch.save(network.state_dict(), published)
    for file, metadata in ((path, {"data": {"images": 10}}), (published, {})):
        loaded = read_weights(file, "ggcnn")
        assert all(np.array_equal(v, loaded[key]) for key, v in network.state_dict().items())
        assert read_metadata(file) == metadata


def test_shipped_weights_load_and_know_how_they_were_made() -> None:
    load_ggcnn()
    metadata = read_metadata(Path("perception/weights/ggcnn.safetensors"))
    assert metadata["recipe"]["data"]["images"] == 16384


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
    def fill(one):
        return torch.full_like(one, value) if one.is_floating_point() else one

    return tensors(lambda state, _: {key: fill(one) for key, one in state.items()})


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
        load_ggcnn(path)
    text = str(error.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    assert "; " in text
    assert len(text) < 500
    assert not (tmp_path / "ran").exists()


ALLOWED = np.zeros((300, 300), dtype=bool)


ALLOWED[100:160, 50:90] = True


IMAGE = np.zeros((300, 300), dtype=np.float32)


@pytest.mark.parametrize("source", [RandomPoints(), SpreadPoints()])
def test_points_lie_where_a_grasp_may_be_and_are_the_same_again(source) -> None:
    one, again = (source.propose(IMAGE, ALLOWED).candidates for _ in range(2))
    assert (one.pixel == again.pixel).all()
    u, v = one.pixel.astype(int).T
    assert ALLOWED[v, u].all()
    assert len(np.unique(one.pixel, axis=0)) == len(u)
    assert (one.quality == 1.0).all()


def test_without_torch_there_is_a_detector_and_a_file_of_torch_names_the_extra(tmp_path: Path):
    torch.save({}, tmp_path / "w.pt")
    code = (
        "import sys; sys.modules['torch'] = None\n"
        "from pathlib import Path\n"
        "from perception import GraspDetector\n"
        "from robots import load_robot\n"
        "gripper = load_robot('frankie').gripper\n"
        "GraspDetector.shipped(gripper)\n"
        "GraspDetector.shipped(gripper, Path(sys.argv[1]))\n"
    )
    run = [sys.executable, "-c", code, str(tmp_path / "w.pt")]
    last = subprocess.run(run, capture_output=True, text=True).stderr.splitlines()[-1]
    assert "w.pt: a file of PyTorch needs" in last
    assert last.endswith('"frankie-task[training]"')
