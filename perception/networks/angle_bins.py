"""The angle-bin network: grasp quality and width of 16 closing directions at every cell.

GG-CNN regresses one direction per pixel; where several are good, it learns their average, which may
be bad. Here every direction has its own quality and width, on a grid three times as coarse.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from perception.grasps.network_input import ANGLE_BINS

CHANNELS = (24, 40, 64)  # at 1/3, 1/6 and 1/12 of the image size


def _block(before: int, after: int, size: int = 3, stride: int = 1, dilation: int = 1) -> nn.Module:
    """Convolution without bias, batch norm, ReLU; divides the side by the stride."""
    padding = (size // 2) * dilation if stride < 3 else (size - stride) // 2
    return nn.Sequential(
        nn.Conv2d(before, after, size, stride, padding, dilation, bias=False),
        nn.BatchNorm2d(after),
        nn.ReLU(inplace=True),
    )


class AngleBinNetwork(nn.Module):
    """An encoder and decoder with skip connections and dilated residual blocks."""

    def __init__(self) -> None:
        super().__init__()
        fine, middle, coarse = CHANNELS
        self.stem = nn.Sequential(_block(1, fine, 9, stride=3), _block(fine, fine))
        self.to_middle = nn.Sequential(_block(fine, middle, stride=2), _block(middle, middle))
        self.to_coarse = _block(middle, coarse, stride=2)
        self.around = nn.ModuleList(_block(coarse, coarse, dilation=d) for d in (1, 2, 4))
        self.from_coarse = nn.Conv2d(coarse, middle, 1)
        self.at_middle = _block(middle, middle)
        self.from_middle = nn.Conv2d(middle, fine, 1)
        self.at_fine = _block(fine, fine + 8)
        self.head = nn.Conv2d(fine + 8, 2 * ANGLE_BINS, 1)
        assert self.head.bias is not None
        nn.init.constant_(
            self.head.bias[:ANGLE_BINS], -4.0
        )  # few directions are good: begin with a low quality

    def forward(self, image: Tensor) -> Tensor:
        """Evaluate on images (B, 1, n, n), depth less its mean in [-1, 1] m, n a multiple of 3.

        Returns (B, 2 ANGLE_BINS, n / 3, n / 3): the logit of the quality of each direction, then
        the width of each [input px / 150].
        """
        fine = self.stem(image)
        middle = self.to_middle(fine)
        coarse = self.to_coarse(middle)
        for block in self.around:
            coarse = coarse + block(coarse)
        middle = self.at_middle(middle + _upsampled(self.from_coarse(coarse), middle))
        fine = self.at_fine(fine + _upsampled(self.from_middle(middle), fine))
        return torch.as_tensor(self.head(fine))


def _upsampled(values: Tensor, like: Tensor) -> Tensor:
    size = list(like.shape[-2:])
    return functional.interpolate(values, size=size, mode="bilinear", align_corners=False)
