"""The work envelope: the hand positions that a wearer can hold without getting tired."""

from .envelope import BRANCHES, CONDITIONS, SUSTAINED, Envelope, work_envelope
from .holding import Holding

__all__ = ["BRANCHES", "CONDITIONS", "SUSTAINED", "Envelope", "Holding", "work_envelope"]
