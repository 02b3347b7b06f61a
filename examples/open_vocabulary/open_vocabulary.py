"""Any words as kinds of objects, by an image encoder and features of words that you bring."""

import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from frankie_task import Labelled

FOLDER = "OPEN_VOCABULARY"  # environment variable: where the weights are
_SIDE = 224  # of the crop of an object [px]
_SHARPNESS = 100.0  # of the softmax over cosines: the logit scale of CLIP


class OpenVocabulary:
    """Each object is the word whose feature is nearest to that of its picture."""

    def __init__(self) -> None:
        folder = Path(os.environ.get(FOLDER, "."))
        if not (folder / "words.npz").is_file():
            raise ValueError(f"set {FOLDER} to a folder with words.npz and encoder.onnx or .pt2")
        with np.load(folder / "words.npz", allow_pickle=False) as words:
            self._words = list(words.files)
            self._features = _unit(np.stack([words[word] for word in self._words]))
        self.kinds = tuple(word for word in self._words if not word.startswith("_"))
        self._encode = _encoder(folder)

    def recognise(self, frame, objects) -> list[Labelled]:
        """A word of each object; none where one that begins with `_` is nearest."""
        if frame.colour is None or not len(objects):
            return []
        crops = (_crop(frame.colour, one.box) for one in objects)
        seen = _unit(np.stack([self._encode(crop) for crop in crops]))
        likeness = _SHARPNESS * seen @ self._features.T
        shares = np.exp(likeness - likeness.max(axis=1, keepdims=True))
        shares /= shares.sum(axis=1, keepdims=True)
        best = [(self._words[int(row.argmax())], float(row.max())) for row in shares]
        return [
            Labelled(kind=word, box=one.box, score=share)
            for one, (word, share) in zip(objects, best, strict=True)
            if word in self.kinds
        ]


def _crop(colour: np.ndarray, box: tuple[int, int, int, int]) -> np.ndarray:
    """(1, 3, 224, 224) of an object in its box, 0 to 1."""
    left, top, right, bottom = box
    crop = cv2.resize(colour[top : bottom + 1, left : right + 1], (_SIDE, _SIDE))
    return crop.astype(np.float32).transpose(2, 0, 1)[None] / 255.0


def _unit(features: np.ndarray) -> np.ndarray:
    features = np.asarray(features, dtype=np.float64).reshape(len(features), -1)
    return features / np.maximum(np.linalg.norm(features, axis=1, keepdims=True), 1e-12)


def _encoder(folder: Path) -> Callable[[np.ndarray], np.ndarray]:
    """From (1, 3, 224, 224) to the feature; with a batch of one any exported encoder works."""
    if (folder / "encoder.onnx").is_file():
        network = cv2.dnn.readNetFromONNX(str(folder / "encoder.onnx"))

        def encode(crop: np.ndarray) -> np.ndarray:
            network.setInput(crop)
            return network.forward()

        return encode
    import torch

    module = torch.export.load(folder / "encoder.pt2").module()
    return lambda crop: module(torch.from_numpy(crop)).detach().numpy()
