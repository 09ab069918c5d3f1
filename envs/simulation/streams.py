"""Random numbers of an episode: a stream for every purpose, so that none depends on another."""

import zlib

import numpy as np

from ...checks import HIGHEST_SEED


def stream(seed: int, episode: int, purpose: str, part: int = 0) -> np.random.Generator:
    """Returns the generator of one purpose in one episode.

    Draws for one purpose do not change those for another, nor those of other rows of a vector
    environment, in whatever order they are made.

    Args:
        seed: Seed of the row.
        episode: Number of the episode since the row was seeded.
        purpose: Name of the purpose, such as "motion".
        part: Number of the stretch of the episode, for series that are drawn in stretches.
    """
    return np.random.default_rng((seed, episode, zlib.crc32(purpose.encode()), part))


def fresh_seed() -> int:
    """Returns a seed from the operating system's entropy."""
    return int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) & HIGHEST_SEED
