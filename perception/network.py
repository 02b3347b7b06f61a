"""GG-CNN: one small network that says, for every pixel, how good a grasp there is and which one.

`GGCNN` is the network as published (Morrison, Corke and Leitner, "Closing the Loop for Robotic
Grasping", RSS 2018), layer for layer and under the published parameter names, so that published
weights load. Evaluated as it is written it is slow on a processor, because nearly all the work
is in one 9x9 transposed convolution. `rewritten` turns each transposed convolution into an equal
3x3 convolution followed by a pixel shuffle, and the four heads into one; `evaluate` runs that
form, for training and for `Inference` alike.
"""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save_file
from torch import Tensor, nn
from torch.nn import functional

from perception.maps import WeightsError

_HEADS = ("pos_output", "cos_output", "sin_output", "width_output")


class GGCNN(nn.Module):
    """The published network: depth in, four maps out.

    The angle maps are the cosine and sine of twice the closing direction, measured in the image
    from the right and anticlockwise as seen (against the direction of v).
    """

    def __init__(self) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(1, 32, 9, stride=3, padding=3)
        self.conv2 = nn.Conv2d(32, 16, 5, stride=2, padding=2)
        self.conv3 = nn.Conv2d(16, 8, 3, stride=2, padding=1)
        self.convt1 = nn.ConvTranspose2d(8, 8, 3, stride=2, padding=1, output_padding=1)
        self.convt2 = nn.ConvTranspose2d(8, 16, 5, stride=2, padding=2, output_padding=1)
        self.convt3 = nn.ConvTranspose2d(16, 32, 9, stride=3, padding=3, output_padding=1)
        self.pos_output = nn.Conv2d(32, 1, 2)
        self.cos_output = nn.Conv2d(32, 1, 2)
        self.sin_output = nn.Conv2d(32, 1, 2)
        self.width_output = nn.Conv2d(32, 1, 2)
        for module in self.children():
            assert isinstance(module, nn.Conv2d | nn.ConvTranspose2d)
            nn.init.xavier_uniform_(module.weight)

    def forward(self, image: Tensor) -> Tensor:
        """Evaluate layer by layer, as published.

        Args:
            image: (B, 1, 300, 300) depth less its mean [m], clipped to [-1, 1].

        Returns:
            (B, 4, 300, 300): quality, cosine, sine, width / 150 px.
        """
        x = image
        for layer in (self.conv1, self.conv2, self.conv3, self.convt1, self.convt2, self.convt3):
            x = functional.relu(layer(x))
        return torch.cat([getattr(self, head)(x) for head in _HEADS], dim=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rewritten:
    """The kernels of an equal network without transposed convolutions and with one head."""

    down: tuple[tuple[Tensor, Tensor, int, int], ...]
    """Weight, bias, stride, padding of each convolution."""
    up: tuple[tuple[Tensor, Tensor, int], ...]
    """3x3 weight, bias and shuffle factor of each enlargement."""
    head: tuple[Tensor, Tensor]


def rewritten(network: GGCNN) -> Rewritten:
    """Kernels of the fast form; gradients flow back to the network's own parameters."""
    down = tuple(
        (layer.weight, layer.bias, layer.stride[0], int(layer.padding[0]))
        for layer in (network.conv1, network.conv2, network.conv3)
        if layer.bias is not None
    )
    up = tuple(_enlargement(layer) for layer in (network.convt1, network.convt2, network.convt3))
    heads = [getattr(network, head) for head in _HEADS]
    return Rewritten(
        down=down,
        up=up,
        head=(torch.cat([h.weight for h in heads]), torch.cat([h.bias for h in heads])),
    )


def _enlargement(layer: nn.ConvTranspose2d) -> tuple[Tensor, Tensor, int]:
    """3x3 convolution whose pixel shuffle equals a transposed convolution.

    Output s q + r of a transposed convolution with stride s and padding p sums input q + o times
    tap r + p - s o, which is a tap of the kernel for o in (-1, 0, 1) alone: one 3-tap kernel for
    each of the s phases r.
    """
    stride, padding = layer.stride[0], int(layer.padding[0])
    size = layer.kernel_size[0]
    phase = torch.arange(stride)[:, None]
    offset = torch.arange(-1, 2)[None, :]
    tap = phase + padding - stride * offset
    tap = torch.where((tap >= 0) & (tap < size), tap, size)  # `size` is the zero appended below
    weight = functional.pad(layer.weight, (0, 1, 0, 1))
    weight = weight[:, :, tap[:, None, :, None], tap[None, :, None, :]]  # (in, out, s, s, 3, 3)
    weight = weight.permute(1, 2, 3, 0, 4, 5).reshape(-1, weight.shape[0], 3, 3)
    assert layer.bias is not None
    return weight, layer.bias.repeat_interleave(stride * stride), stride


def evaluate(kernels: Rewritten, image: Tensor) -> Tensor:
    """Same result as `GGCNN.forward` to rounding, several times faster on a processor."""
    x = image
    for weight, bias, stride, padding in kernels.down:
        x = functional.conv2d(x, weight, bias, stride=stride, padding=padding).relu_()
    for index, (weight, bias, factor) in enumerate(kernels.up):
        # The last enlargement has one row and column more than a multiple of its factor.
        last = index == len(kernels.up) - 1
        x = functional.pad(x, (1, 2, 1, 2)) if last else functional.pad(x, (1, 1, 1, 1))
        x = functional.pixel_shuffle(functional.conv2d(x, weight, bias).relu_(), factor)
    height, width = image.shape[2:]
    x = x[:, :, : height + 1, : width + 1]
    return functional.conv2d(x, *kernels.head)


class Inference:
    """A network frozen for use: fast form, memory laid out by pixel, one thread.

    Args:
        network: whose weights to freeze; later changes to it have no effect here.
    """

    def __init__(self, network: GGCNN) -> None:
        kernels = rewritten(network)
        self._kernels = Rewritten(
            down=tuple((_frozen(w), b.detach().clone(), s, p) for w, b, s, p in kernels.down),
            up=tuple((_frozen(w), b.detach().clone(), s) for w, b, s in kernels.up),
            head=(_frozen(kernels.head[0]), kernels.head[1].detach().clone()),
        )

    def __call__(self, image: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Maps of one image.

        Args:
            image: (300, 300) as `GGCNN.forward` takes it.

        Returns:
            (4, 300, 300): quality, cosine, sine, width / 150 px.
        """
        batch = torch.from_numpy(np.ascontiguousarray(image))[None, None]
        threads = torch.get_num_threads()
        if threads != 1:  # on a busy machine several threads wait for each other
            torch.set_num_threads(1)
        try:
            with torch.inference_mode():
                maps = evaluate(self._kernels, batch.contiguous(memory_format=torch.channels_last))
        finally:
            if threads != 1:
                torch.set_num_threads(threads)
        return np.ascontiguousarray(maps[0].numpy())


def _frozen(weight: Tensor) -> Tensor:
    return weight.detach().clone().contiguous(memory_format=torch.channels_last)


def load_network(path: Path) -> GGCNN:
    """A network with the weights of a file.

    Args:
        path: a safetensors file, or a state dict saved by PyTorch under the published names.

    Raises:
        WeightsError: there is no such file, or it does not hold weights of this network.
    """
    network = GGCNN()
    state = _read(path)
    expected = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    found = {name: tuple(value.shape) for name, value in state.items()}
    if found != expected:
        wrong = sorted(
            name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name)
        )
        raise WeightsError(
            f"{path}: not the weights of a GG-CNN ({len(wrong)} tensors missing, unknown or of "
            f"another shape, first: {wrong[0]}); give weights that were trained for it"
        )
    if not all(bool(torch.isfinite(value).all()) for value in state.values()):
        raise WeightsError(f"{path}: some weights are not finite; train or download them again")
    network.load_state_dict({name: value.float() for name, value in state.items()})
    return network.eval()


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


def save_network(network: GGCNN, path: Path, metadata: Mapping[str, str]) -> None:
    """Write the weights as safetensors, with what is to be known about them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    state = {name: value.detach().contiguous() for name, value in network.state_dict().items()}
    save_file(state, path, metadata=dict(metadata))


def read_metadata(path: Path) -> dict[str, str]:
    """What `save_network` wrote beside the weights."""
    with safe_open(path, framework="pt") as file:
        return dict(file.metadata() or {})
