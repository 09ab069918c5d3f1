"""`python -m activesuit.benchmarks TOPIC`: see `bench`."""

import sys
from collections.abc import Sequence

from ..scripts.main import mistakes_reported
from ..scripts.options import parsed
from .bench import bench


def main(arguments: Sequence[str]) -> None:
    """Measures a topic; after a user's mistake, prints one sentence and exits with code 2."""
    with mistakes_reported():
        parsed(bench, "python -m activesuit.benchmarks", arguments)()


if __name__ == "__main__":
    main(sys.argv[1:])
