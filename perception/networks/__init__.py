"""The grasp networks: inference, weights files and training. Importing this imports torch."""

from perception.networks.proposer import Proposer
from perception.networks.training import RoundReport, TrainingSettings, train
from perception.networks.weights import (
    DEFAULT_NETWORK,
    NETWORKS,
    load_network,
    read_metadata,
    save_network,
    shipped_network,
)

__all__ = [
    "DEFAULT_NETWORK",
    "NETWORKS",
    "Proposer",
    "RoundReport",
    "TrainingSettings",
    "load_network",
    "read_metadata",
    "save_network",
    "shipped_network",
    "train",
]
