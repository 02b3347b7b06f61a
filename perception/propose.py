"""Where a network would grasp: one interface to all of them, depth in, ranked candidates out.

For use a network is frozen into its fastest equal form: batch norms folded into the convolutions,
transposed convolutions rewritten, memory laid out by pixel, one thread.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import NamedTuple, TypeAlias

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from perception.angle_bins import AngleBinNetwork
from perception.arrays import Image, Mask
from perception.ggcnn import GGCNN, Rewritten, evaluate, rewritten
from perception.maps import BINS, STRIDE
from perception.postprocess import Candidates, bin_candidates, find_candidates, grasp_maps
from perception.refine import ALL_DIRECTIONS
from perception.weights import Network, name_of


class Proposals(NamedTuple):
    """What a network would try in one image."""

    candidates: Candidates
    """Best first."""
    quality: Image
    """(SIZE, SIZE) for people to look at; 0 where no grasp is allowed."""
    directions: int
    """How many closing directions are worth trying at each candidate: where several are good,
    GG-CNN's angle is their average, which may be none of them."""


Forward: TypeAlias = Callable[[Tensor], Tensor]


class Proposer:
    """A network ready for use.

    Args:
        network: whose weights to freeze; later changes to it have no effect here.
        plain: evaluate it layer by layer as it is written, to compare with.
    """

    def __init__(self, network: Network, *, plain: bool = False) -> None:
        self.name = name_of(network) + (", plain torch" if plain else "")
        """What it is called in tables."""
        self._bins = isinstance(network, AngleBinNetwork)
        self._forward: Forward = deepcopy(network).eval() if plain else frozen(network)

    def __call__(self, image: Image, allowed: Mask) -> Proposals:
        """Candidates in one image.

        Args:
            image: (SIZE, SIZE) depth less its mean, clipped to [-1, 1] [m].
            allowed: (SIZE, SIZE) where a grasp may be.
        """
        answer = self.answer(image)
        if self._bins:
            middle = slice(STRIDE // 2, None, STRIDE)
            found = bin_candidates(answer.transpose(1, 2, 0), allowed[middle, middle])
            return Proposals(*found, directions=3)
        maps = grasp_maps(answer, allowed)
        return Proposals(find_candidates(maps), maps.quality, directions=ALL_DIRECTIONS)

    def answer(self, image: Image) -> Image:
        """The network's maps, (channels, rows, columns), of an image as `__call__` takes it.

        The qualities of an `AngleBinNetwork` are shares, no longer logits.
        """
        batch = torch.from_numpy(np.ascontiguousarray(image))[None, None]
        threads = torch.get_num_threads()
        if threads != 1:  # on a busy machine several threads wait for each other
            torch.set_num_threads(1)
        try:
            with torch.inference_mode():
                maps = self._forward(batch)
                if self._bins:
                    maps[:, :BINS].sigmoid_()
                answer: Image = maps[0].numpy()
        finally:
            if threads != 1:
                torch.set_num_threads(threads)
        return answer


def frozen(network: Network) -> Forward:
    """A function equal to a network but for rounding, and several times as fast."""
    if isinstance(network, GGCNN):
        kernels = _by_pixel(rewritten(network))
        return lambda image: evaluate(kernels, _laid_out(image))
    fused = _folded(deepcopy(network).eval())
    fused.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return lambda image: torch.as_tensor(fused(_laid_out(image)))


def _laid_out(values: Tensor) -> Tensor:
    return values.contiguous(memory_format=torch.channels_last)


def _by_pixel(kernels: Rewritten) -> Rewritten:
    def own(values: Tensor) -> Tensor:
        return values.detach().clone()

    weight, bias = kernels.head
    return Rewritten(
        down=tuple((_laid_out(own(w)), own(b), s, p) for w, b, s, p in kernels.down),
        up=tuple((_laid_out(own(w)), own(b), factor) for w, b, factor in kernels.up),
        head=(_laid_out(own(weight)), own(bias)),
    )


def _folded(module: nn.Module) -> nn.Module:
    """Every batch norm behind a convolution folded into it."""
    for name, child in module.named_children():
        setattr(module, name, _folded(child))
    if isinstance(module, nn.Sequential):
        layers = list(module)
        for index in range(len(layers) - 1):
            convolution, norm = layers[index : index + 2]
            if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
                layers[index] = fuse_conv_bn_eval(convolution, norm)
                layers[index + 1] = nn.Identity()
        return nn.Sequential(*layers)
    return module
