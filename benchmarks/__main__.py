"""`python -m activesuit.benchmarks TOPIC`: see `bench`."""

import sys

from ..scripts.main import mistakes_reported
from ..scripts.parsing import parsed
from .bench import bench

if __name__ == "__main__":
    with mistakes_reported():
        parsed(bench, "python -m activesuit.benchmarks", sys.argv[1:])()
