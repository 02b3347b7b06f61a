"""GG-CNN: grasp quality, angle and width for every pixel of a depth image.

`GGCNN` is the published network (Morrison, Corke and Leitner, "Closing the Loop for Robotic
Grasping", RSS 2018) with the published parameter names, so that published weights load. On a CPU
nearly all its work is in one 9x9 transposed convolution. `subpixel_form` turns each transposed
convolution into an equal 3x3 convolution followed by a pixel shuffle, and the four heads into one.
Its maps in the middle of every cell of 3x3 pixels, where candidates are sought, take a third of
that time again.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

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

        From images (B, 1, 300, 300), depth less its mean in [-1, 1] m, to (B, 4, 300, 300):
        quality, cosine, sine, width / 150 px.
        """
        x = image
        for layer in (self.conv1, self.conv2, self.conv3, self.convt1, self.convt2, self.convt3):
            x = functional.relu(layer(x))
        return torch.cat([getattr(self, head)(x) for head in _HEADS], dim=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class SubpixelKernels:
    """An equal network without transposed convolutions and with one head."""

    down: tuple[tuple[Tensor, Tensor, int, int], ...]  # weight, bias, stride, padding
    up: tuple[tuple[Tensor, Tensor, int], ...]  # 3x3 weight, bias and shuffle factor of each
    head: tuple[Tensor, Tensor]


def subpixel_form(network: GGCNN, *, cells: bool) -> SubpixelKernels:
    """Kernels of the fast form; gradients flow back to the network's own parameters.

    With `cells` they give the output in the middle of each cell of 3x3 pixels only.
    """
    down = tuple(
        (layer.weight, layer.bias, layer.stride[0], int(layer.padding[0]))
        for layer in (network.conv1, network.conv2, network.conv3)
        if layer.bias is not None
    )
    *up, (weight, bias, factor) = (
        _subpixel_convolution(layer) for layer in (network.convt1, network.convt2, network.convt3)
    )
    heads = [getattr(network, name) for name in _HEADS]
    head, head_bias = torch.cat([h.weight for h in heads]), torch.cat([h.bias for h in heads])
    if cells:  # the heads see 2x2 pixels, those of phase 1 and 2 along each axis
        split = weight.view(-1, factor, factor, *weight.shape[1:])
        weight, bias = split[:, 1:, 1:].flatten(0, 2), bias.view(-1, factor**2)[:, :4].flatten()
        head, factor = head.flatten(1)[..., None, None], 1
    return SubpixelKernels(down=down, up=(*up, (weight, bias, factor)), head=(head, head_bias))


def _subpixel_convolution(layer: nn.ConvTranspose2d) -> tuple[Tensor, Tensor, int]:
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


def evaluate(kernels: SubpixelKernels, image: Tensor) -> Tensor:
    """Same result as `GGCNN.forward` to rounding, several times faster on a CPU; or its cells."""
    x = image
    for weight, bias, stride, padding in kernels.down:
        x = functional.conv2d(x, weight, bias, stride=stride, padding=padding).relu_()
    for index, (weight, bias, factor) in enumerate(kernels.up):
        # The last upsampling has one row and column more than a multiple of its factor.
        end = 2 if factor > 1 and index == len(kernels.up) - 1 else 1
        x = functional.pad(x, (1, end, 1, end))
        x = functional.conv2d(x, weight, bias).relu_()
        if factor > 1:
            x = functional.pixel_shuffle(x, factor)
    height, width = image.shape[2:]
    x = x[:, :, : height + 1, : width + 1]
    return functional.conv2d(x, *kernels.head)
