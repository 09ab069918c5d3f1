"""Rewards of a user's own, right and wrong ones."""

import numpy as np


def gentle(terms, measured):
    """The shipped reward, and a fine where the arm is lost."""
    cost = terms["effort"] + terms["tracking"] + terms["smoothness"]
    return np.where(measured["lost"], -1.0, 1 / (1 + cost))


def costly(terms, measured):
    """Without a lower bound, so that ending an episode early pays."""
    return -terms["effort"]


def nan(terms, measured):
    return np.full(len(terms["effort"]), np.nan)


def scalar(terms, measured):
    return 1.0


def failing(terms, measured):
    return measured["joy"]
