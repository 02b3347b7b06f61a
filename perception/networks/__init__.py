"""The grasp networks: inference, weights files and training. Importing this imports torch."""

from perception.networks.proposer import Proposals, Proposer
from perception.networks.training import RoundReport, TrainingResult, TrainingSettings, train
from perception.networks.weights import (
    DEFAULT_NETWORK,
    NETWORKS,
    Network,
    load_network,
    network_name,
    read_metadata,
    save_network,
    shipped_network,
)

__all__ = [
    "DEFAULT_NETWORK",
    "NETWORKS",
    "Network",
    "Proposals",
    "Proposer",
    "RoundReport",
    "TrainingResult",
    "TrainingSettings",
    "load_network",
    "network_name",
    "read_metadata",
    "save_network",
    "shipped_network",
    "train",
]
