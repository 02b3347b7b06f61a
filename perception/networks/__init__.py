"""The grasp networks: inference, weights files and training. Importing this imports torch."""

from perception.networks.hold import HoldNetwork, load_hold, probability_by, shipped_hold
from perception.networks.hold_training import FitReport, FitSettings, fit_hold
from perception.networks.proposer import Proposer
from perception.networks.training import RoundReport, TrainingSettings, train
from perception.networks.weights import (
    DEFAULT_NETWORK,
    NETWORKS,
    load_network,
    save_network,
    shipped_network,
)
