"""Inference of the grasp networks: depth image in, ranked candidates out.

A network is converted into an equivalent faster form: batch norms are folded into the convolutions,
transposed convolutions become sub-pixel convolutions, memory is channels last, and one thread is
used.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from perception.frame import Image, Mask
from perception.grasps.candidates import Proposals
from perception.grasps.network_input import ANGLE_BINS, OUTPUT_STRIDE
from perception.grasps.refinement import ALL_DIRECTIONS
from perception.networks.angle_bins import AngleBinNetwork
from perception.networks.ggcnn import GGCNN, SubpixelKernels, evaluate, subpixel_form
from perception.networks.output_maps import bin_candidates, find_candidates, grasp_maps
from perception.networks.weights import Network, network_name

Forward: TypeAlias = Callable[[Tensor], Tensor]


class Proposer:
    """A network ready for inference.

    Args:
        network: copied; later changes to it have no effect.
        plain: evaluate it layer by layer as written, for comparison.
    """

    def __init__(self, network: Network, *, plain: bool = False) -> None:
        self.name = network_name(network) + (", plain torch" if plain else "")
        self._bins = isinstance(network, AngleBinNetwork)
        self._forward: Forward = deepcopy(network).eval() if plain else inference_form(network)

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        output = self.infer(image)
        if self._bins:
            middle = slice(OUTPUT_STRIDE // 2, None, OUTPUT_STRIDE)
            found = bin_candidates(output.transpose(1, 2, 0), allowed[middle, middle])
            return Proposals(*found, directions=3)
        maps = grasp_maps(output, allowed)
        return Proposals(find_candidates(maps), maps.quality, directions=ALL_DIRECTIONS)

    def infer(self, image: Image) -> Image:
        """The network's output maps, (channels, rows, columns), of an image as for `propose`.

        The qualities of an `AngleBinNetwork` are probabilities, no longer logits.
        """
        batch = torch.from_numpy(np.ascontiguousarray(image))[None, None]
        with one_thread(), torch.inference_mode():
            maps = self._forward(batch)
            if self._bins:
                maps[:, :ANGLE_BINS].sigmoid_()
            output: Image = maps[0].numpy()
        return output


def inference_form(network: Network) -> Forward:
    """A function equal to a network up to rounding, and several times as fast."""
    if isinstance(network, GGCNN):
        kernels = _channels_last_kernels(subpixel_form(network))
        return lambda image: evaluate(kernels, _channels_last(image))
    fused = fused_form(network)
    return lambda image: torch.as_tensor(fused(_channels_last(image)))


def fused_form(network: nn.Module) -> nn.Module:
    """A copy equal up to rounding, its batch norms folded, its memory channels last."""
    fused = _fold_batch_norms(deepcopy(network).eval())
    fused.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return fused


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch compute on one thread: on a busy machine several wait for each other."""
    threads = torch.get_num_threads()
    if threads != 1:
        torch.set_num_threads(1)
    try:
        yield
    finally:
        if threads != 1:
            torch.set_num_threads(threads)


def _channels_last(values: Tensor) -> Tensor:
    return values.contiguous(memory_format=torch.channels_last)


def _channels_last_kernels(kernels: SubpixelKernels) -> SubpixelKernels:
    def copy(values: Tensor) -> Tensor:
        return values.detach().clone()

    weight, bias = kernels.head
    return SubpixelKernels(
        down=tuple((_channels_last(copy(w)), copy(b), s, p) for w, b, s, p in kernels.down),
        up=tuple((_channels_last(copy(w)), copy(b), factor) for w, b, factor in kernels.up),
        head=(_channels_last(copy(weight)), copy(bias)),
    )


def _fold_batch_norms(module: nn.Module) -> nn.Module:
    """Fold every batch norm into the convolution before it."""
    for name, child in module.named_children():
        setattr(module, name, _fold_batch_norms(child))
    if isinstance(module, nn.Sequential):
        layers = list(module)
        for index in range(len(layers) - 1):
            convolution, norm = layers[index : index + 2]
            if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
                layers[index] = fuse_conv_bn_eval(convolution, norm)
                layers[index + 1] = nn.Identity()
        return nn.Sequential(*layers)
    return module
