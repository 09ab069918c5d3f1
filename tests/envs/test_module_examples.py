"""The examples at the top of the central modules run, and print what they say."""

import doctest
from importlib import import_module

import pytest

MODULES = (
    *("", ".arm_env", ".vector_env", ".episodes", ".setup", ".simulation.simulation"),
    ".simulation.bound_kernels",
)


@pytest.mark.parametrize("name", MODULES)
def test_the_example_of_a_module(name):
    found = doctest.testmod(import_module(f"activesuit.envs{name}"))
    assert found.attempted > 3 and not found.failed
