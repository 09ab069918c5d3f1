"""Random numbers of an episode: a stream for every purpose, so that none depends on another."""

import zlib

import numpy as np

HIGHEST_SEED = 2**63 - 1


def stream(seed: int, episode: int, purpose: str, part: int = 0) -> np.random.Generator:
    """Returns the generator of one purpose in one episode.

    What is drawn for one purpose changes nothing for the others, nor for other rows of a vector
    environment, in whatever order they draw.

    Args:
        seed: Seed of the row.
        episode: Number of the episode since the row was seeded.
        purpose: Name of what is drawn, such as "motion".
        part: Number of the stretch of the episode, for what is drawn piece by piece.
    """
    return np.random.default_rng((seed, episode, zlib.crc32(purpose.encode()), part))


def fresh_seed() -> int:
    """Returns a seed from the operating system's entropy."""
    return int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) & HIGHEST_SEED
