"""The grasp networks in PyTorch, for training; `perception.networks` evaluates them in NumPy."""

import json
from collections.abc import Mapping
from pathlib import Path

import torch
from safetensors.torch import save_file
from torch import Tensor, nn
from torch.nn import functional

from perception import FAR_SHAPE, HOLD_NUMBERS, NEAR_SHAPE, HoldInputs, read_weights, subpixel_taps

_HEADS = ("pos_output", "cos_output", "sin_output", "width_output")
_CHANNELS = (16, 32)  # of the hold network, of the first layer and of those after it
_HIDDEN = 64  # units before the last


class GGCNN(nn.Module):
    """The published network: depth in, four maps out; see `perception.GGCNN`."""

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

        From images (B, 1, 300, 300), depth less its mean in [-1, 1] m, to (B, 4, 300, 300):
        quality, cosine, sine, width / 150 px.
        """
        x = image
        for layer in (self.conv1, self.conv2, self.conv3, self.convt1, self.convt2, self.convt3):
            x = functional.relu(layer(x))
        return torch.cat([getattr(self, head)(x) for head in _HEADS], dim=1)

    def in_subpixels(self, image: Tensor) -> Tensor:
        """The same to rounding, in half the time: without transposed convolutions, one head."""
        height, width = image.shape[2:]
        x = image
        for layer in (self.conv1, self.conv2, self.conv3):
            x = functional.relu(layer(x))
        # The last upsampling has one row and column more than a multiple of its factor.
        for upsampling, end in ((self.convt1, 1), (self.convt2, 1), (self.convt3, 2)):
            x = _subpixel_convolution(upsampling, functional.pad(x, (1, end, 1, end)))
        heads = [getattr(self, name) for name in _HEADS]
        weight, bias = torch.cat([h.weight for h in heads]), torch.cat([h.bias for h in heads])
        return functional.conv2d(x[:, :, : height + 1, : width + 1], weight, bias)


def _subpixel_convolution(layer: nn.ConvTranspose2d, padded: Tensor) -> Tensor:
    """A transposed convolution and ReLU as a 3x3 convolution whose pixels are shuffled."""
    stride, size = layer.stride[0], layer.kernel_size[0]
    tap = torch.from_numpy(subpixel_taps(size, stride=stride, padding=int(layer.padding[0])))
    weight = functional.pad(layer.weight, (0, 1, 0, 1))
    weight = weight[:, :, tap[:, None, :, None], tap[None, :, None, :]]  # (in, out, s, s, 3, 3)
    weight = weight.permute(1, 2, 3, 0, 4, 5).reshape(-1, weight.shape[0], 3, 3)
    assert layer.bias is not None
    bias = layer.bias.repeat_interleave(stride * stride)
    return functional.pixel_shuffle(functional.conv2d(padded, weight, bias).relu_(), stride)


class HoldNetwork(nn.Module):
    """Two small stacks of convolutions, one for each map, and a perceptron on both."""

    def __init__(self) -> None:
        super().__init__()
        first, then = _CHANNELS
        pool = nn.MaxPool2d(2)
        blocks = _block(3, first), _block(first, then), _block(then, then), _block(then, then)
        self.near = nn.Sequential(blocks[0], pool, blocks[1], pool, blocks[2], pool, blocks[3])
        self.far = nn.Sequential(
            _block(3, first), pool, _block(first, then), pool, _block(then, then), pool
        )
        cells = sum(rows * columns // 64 for rows, columns in (NEAR_SHAPE, FAR_SHAPE))
        self.head = nn.Sequential(
            nn.Dropout(0.3),
            nn.Linear(then * cells + HOLD_NUMBERS, _HIDDEN),
            nn.ReLU(),
            nn.Dropout(0.2),
            nn.Linear(_HIDDEN, 1),
        )

    def forward(self, near: Tensor, far: Tensor, numbers: Tensor) -> Tensor:
        """(N,) logits of the probability; the arguments are those of `as_tensors`."""
        seen = [self.near(near).flatten(1), self.far(far).flatten(1)]
        return torch.as_tensor(self.head(torch.cat([*seen, numbers], dim=1))[:, 0])


def _block(before: int, after: int) -> nn.Module:
    return nn.Sequential(
        nn.Conv2d(before, after, 3, padding=1, bias=False), nn.BatchNorm2d(after), nn.ReLU()
    )


def as_tensors(inputs: HoldInputs) -> tuple[Tensor, Tensor, Tensor]:
    """Maps (N, 3, height, width) and numbers: the arguments of `HoldNetwork.forward`."""
    near, far, numbers = (torch.from_numpy(each) for each in inputs)
    return near.permute(0, 3, 1, 2), far.permute(0, 3, 1, 2), numbers


def load_hold_network(path: Path) -> HoldNetwork:
    """The network with the weights of a file.

    Raises:
        WeightsError: the file is missing, unreadable or of another network.
    """
    network = HoldNetwork()
    network.load_state_dict(
        {name: torch.from_numpy(value) for name, value in read_weights(path, "hold").items()}
    )
    return network


def save_network(network: nn.Module, path: Path, metadata: Mapping[str, object]) -> None:
    """Write weights as safetensors with metadata, whose values are stored as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    state = {name: value.detach().contiguous() for name, value in network.state_dict().items()}
    save_file(state, path, metadata={key: json.dumps(value) for key, value in metadata.items()})
    path.chmod(0o644)  # safetensors makes it readable by its owner only
