"""Inference of GG-CNN: depth image in, ranked candidates out."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import torch
from torch import Tensor

from perception.frame import Image, Mask
from perception.grasps.candidates import Proposals
from perception.grasps.network_input import OUTPUT_STRIDE
from perception.networks.ggcnn import GGCNN, SubpixelKernels, evaluate, subpixel_form
from perception.networks.output_maps import find_candidates, grasp_maps

_MIDDLE = slice(OUTPUT_STRIDE // 2, None, OUTPUT_STRIDE)  # of the cells [input px]


class Proposer:
    """A network ready for inference; later changes to the network have no effect."""

    name = "ggcnn"

    def __init__(self, network: GGCNN) -> None:
        with torch.inference_mode():
            self._kernels = _channels_last_kernels(subpixel_form(network, cells=True))

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        """See `CandidateSource`."""
        maps = grasp_maps(self.infer(image), allowed[_MIDDLE, _MIDDLE])
        return Proposals(find_candidates(maps), maps.quality_in_input())

    def infer(self, image: Image) -> Image:
        """Output maps (4, 100, 100) in the cells of an image as for `propose`."""
        batch = torch.from_numpy(np.ascontiguousarray(image))[None, None]
        with one_thread(), torch.inference_mode():
            output: Image = evaluate(self._kernels, _channels_last(batch))[0].numpy()
        return output


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
    weight, bias = kernels.head
    return SubpixelKernels(
        down=tuple((_channels_last(w), b.clone(), s, p) for w, b, s, p in kernels.down),
        up=tuple((_channels_last(w), b, factor) for w, b, factor in kernels.up),
        head=(_channels_last(weight), bias),
    )
