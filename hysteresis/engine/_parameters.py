"""Reading the config of each model into its parameter vector. Each reader returns a fault."""

import math

import numpy as np
from numba import njit

from ..jiles_atherton import _forms as forms
from ..preisach._tables import set_parameters
from . import _models as models
from ._faults import (
    AS_MANY,
    ASCENDING,
    AT_LEAST_0,
    CLAMP,
    DENSITY_SIZE,
    FINE,
    FORM,
    FROM_1_TO_1E6,
    NOT_ZERO,
    NUMBER,
    NUMBERS,
    POSITIVE,
    REASONS,
    UNIT,
    config,
)
from ._models import FIRST_KEY
from .native._text import count_words, equals, length, parse_numbers

DEGREE = math.pi / 180


@njit(cache=True)
def count_parts(kind, m, instance, at):
    """Returns the number of thresholds or segments that a config speaks of."""
    if kind == models.PRANDTL_ISHLINSKII:
        return count_words(config(m, instance, FIRST_KEY + 2, at))
    if kind == models.PREISACH:
        return max(count_words(config(m, instance, FIRST_KEY, at)) - 1, 0)
    return 0


@njit(cache=True)
def read_parameters(kind, m, instance, p, at):
    """Fills the parameter vector from the config of a model."""
    if kind == models.JILES_ATHERTON:
        return read_jiles_atherton(m, instance, p, at)
    if kind == models.BOUC_WEN:
        return read_bouc_wen(m, instance, p, at)
    if kind == models.PRANDTL_ISHLINSKII:
        return read_prandtl_ishlinskii(m, instance, p, at)
    return read_preisach(m, instance, p, at)


@njit(cache=True)
def read_scalars(m, instance, first, values, at):
    """Reads one number for each of some consecutive keys."""
    for i in range(values.size):
        if parse_numbers(config(m, instance, first + i, at), values[i : i + 1]) != 1:
            return NUMBER + REASONS * (first + i)
    return FINE


@njit(cache=True)
def read_optional(m, instance, key, value, at):
    """Reads one number if the key is given; `value` keeps what it holds otherwise."""
    text = config(m, instance, key, at)
    if count_words(text) > 0 and parse_numbers(text, value) != 1:
        return NUMBER + REASONS * key
    return FINE


@njit(cache=True)
def read_list(m, instance, key, values, at):
    """Reads as many numbers as `values` has room for."""
    count = parse_numbers(config(m, instance, key, at), values)
    if count < 0:
        return NUMBERS + REASONS * key
    return FINE if count == values.size else AS_MANY + REASONS * key


@njit(cache=True)
def read_jiles_atherton(m, instance, p, at):
    """Ms, a, alpha, c, k in rad or deg; the form and the clamp if given."""
    value = np.empty(5)
    fault = read_scalars(m, instance, FIRST_KEY, value, at)
    if fault != FINE:
        return fault
    for i in (0, 1, 4):
        if not value[i] > 0:
            return POSITIVE + REASONS * (FIRST_KEY + i)
    scale = 1.0
    unit = config(m, instance, FIRST_KEY + 5, at)
    if equals(unit, b"deg"):
        scale = DEGREE
    elif not equals(unit, b"rad"):
        return UNIT + REASONS * (FIRST_KEY + 5)
    form = read_form(config(m, instance, FIRST_KEY + 6, at))
    if form < 0:
        return FORM + REASONS * (FIRST_KEY + 6)
    clamp = read_clamp(config(m, instance, FIRST_KEY + 7, at))
    if clamp < 0:
        return CLAMP + REASONS * (FIRST_KEY + 7)
    Ms, a, alpha, c, k = value
    if form != forms.BULK and not 0 <= c < (1 if form == forms.JILES_1992 else math.inf):
        return AT_LEAST_0 + REASONS * (FIRST_KEY + 3)
    models.jiles_atherton.set_parameters(p, Ms, a * scale, alpha * scale, c, k * scale, form, clamp)
    return FINE


@njit(cache=True)
def read_form(text):
    """Returns the number of a form, by default the first; -1 if there is no such form."""
    if length(text) == 0 or equals(text, b"bulk"):
        return forms.BULK
    if equals(text, b"original"):
        return forms.ORIGINAL
    if equals(text, b"derivative"):
        return forms.DERIVATIVE
    return forms.JILES_1992 if equals(text, b"jiles-1992") else -1


@njit(cache=True)
def read_clamp(text):
    """Returns the number of a clamp, by default none; -1 if there is no such clamp."""
    if length(text) == 0 or equals(text, b"none"):
        return forms.NO_CLAMP
    if equals(text, b"jiles"):
        return forms.JILES_CLAMP
    return forms.IRREVERSIBLE_CLAMP if equals(text, b"irreversible") else -1


@njit(cache=True)
def read_bouc_wen(m, instance, p, at):
    """All but the rest angle must be given."""
    value = np.zeros(7)
    fault = read_scalars(m, instance, FIRST_KEY, value[:6], at)
    if fault == FINE:
        fault = read_optional(m, instance, FIRST_KEY + 6, value[6:], at)
    if fault != FINE:
        return fault
    elastic, hysteretic, A, beta, gamma, n, rest = value
    if hysteretic == 0:
        return NOT_ZERO + REASONS * (FIRST_KEY + 1)
    if not A > 0:
        return POSITIVE + REASONS * (FIRST_KEY + 2)
    if not 1 <= n <= 1e6:
        return FROM_1_TO_1E6 + REASONS * (FIRST_KEY + 5)
    models.bouc_wen.set_parameters(p, elastic, hysteretic, A, beta, gamma, n, rest)
    return FINE


@njit(cache=True)
def read_prandtl_ishlinskii(m, instance, p, at):
    """Stiffness, thresholds and weights of stops must be given; the rest angle may."""
    p[1] = 0.0
    fault = read_scalars(m, instance, FIRST_KEY, p[:1], at)
    if fault == FINE:
        fault = read_optional(m, instance, FIRST_KEY + 1, p[1:2], at)
    count = (p.size - 2) // 2
    if fault == FINE and count == 0:
        fault = NUMBERS + REASONS * (FIRST_KEY + 2)
    for i in range(2):
        if fault == FINE:
            part = p[2 + i * count : 2 + (i + 1) * count]
            fault = read_list(m, instance, FIRST_KEY + 2 + i, part, at)
    if fault != FINE:
        return fault
    below = 0.0
    for threshold in p[2 : 2 + count]:
        if not threshold > below:
            return ASCENDING + REASONS * (FIRST_KEY + 2)
        below = threshold
    return FINE


@njit(cache=True)
def read_preisach(m, instance, p, at):
    """Levels and density must be given; the elastic slopes are 0 unless they are."""
    count = count_parts(models.PREISACH, m, instance, at)
    levels, density = np.zeros(count + 1), np.zeros(count * (count + 1) // 2)
    elastic = np.zeros(count)
    fault = read_list(m, instance, FIRST_KEY, levels, at)
    if fault == FINE and count == 0:
        fault = ASCENDING + REASONS * FIRST_KEY
    if fault == FINE:
        fault = read_list(m, instance, FIRST_KEY + 1, density, at)
        if fault % REASONS == AS_MANY:
            fault = DENSITY_SIZE + REASONS * (FIRST_KEY + 1)
    if fault == FINE and count_words(config(m, instance, FIRST_KEY + 2, at)) > 0:
        fault = read_list(m, instance, FIRST_KEY + 2, elastic, at)
    if fault != FINE:
        return fault
    for i in range(count):
        if not levels[i + 1] > levels[i]:
            return ASCENDING + REASONS * FIRST_KEY
    set_parameters(p, levels, density, elastic)
    return FINE
