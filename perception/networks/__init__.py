"""GG-CNN and the hold network: inference, weights, training. Importing this imports torch."""

from perception.networks.ggcnn import GGCNN
from perception.networks.hold import (
    HoldNetwork,
    load_hold,
    load_hold_network,
    probability_by,
    shipped_hold,
)
from perception.networks.hold_training import FitReport, FitSettings, fit_hold
from perception.networks.proposer import Proposer
from perception.networks.training import RoundReport, TrainingSettings, train
from perception.networks.weights import (
    load_network,
    save_network,
    shipped_network,
)
