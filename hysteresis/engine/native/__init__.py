"""A toolkit for MuJoCo engine plugins that are written in Python and compiled by numba.

A plugin is a set of callbacks that MuJoCo calls from C, without Python's lock and from any thread:
it adds passive forces and measures them with sensors. No C compiler is needed. docs/robot.md builds
one, a joint with Stribeck friction, in forty lines. The steps are

1. a named tuple class of the fields that the callbacks touch, filled by `layout`;
2. a function that defines the callbacks with the decorator `callback`; they get addresses as
   integers, and reach numbers with `pointer_at`, `int32_at` and `doubles`, the config with `config`
   and `parse_numbers`, their own state with `state_of`;
3. `register_plugin`, once per process, before a model that uses the plugin is compiled or loaded.

The functions that a callback calls must be compiled too (`numba.njit`), and none may raise.
`complain` says in a sentence what is wrong, and `init` then returns -1: MuJoCo refuses the model.
"""

from ._instance import (
    FOUND,
    TWICE,
    UNKNOWN,
    begin_complaint,
    complain,
    config,
    is_sensor_of,
    key_name,
    pack_sensors,
    packed,
    plugin_name,
    sensor_kind,
    sensor_name,
    sensor_values,
    set_word,
    state_of,
    state_size,
    word_of,
)
from ._layout import layout
from ._memory import character_at, doubles, int32_at, name2id, pointer_at, store_pointer
from ._registration import (
    STAGE_ACC,
    STAGE_POS,
    STAGE_VEL,
    callback,
    compile_plugin,
    register_plugin,
)
from ._text import (
    add,
    add_choices,
    add_text,
    choice_of,
    count_words,
    ends_with,
    equals,
    issue,
    length,
    parse_numbers,
    starts_with,
)

__all__ = [
    "FOUND",
    "STAGE_ACC",
    "STAGE_POS",
    "STAGE_VEL",
    "TWICE",
    "UNKNOWN",
    "add",
    "add_choices",
    "add_text",
    "begin_complaint",
    "callback",
    "character_at",
    "choice_of",
    "compile_plugin",
    "complain",
    "config",
    "count_words",
    "doubles",
    "ends_with",
    "equals",
    "int32_at",
    "is_sensor_of",
    "issue",
    "key_name",
    "layout",
    "length",
    "name2id",
    "pack_sensors",
    "packed",
    "parse_numbers",
    "plugin_name",
    "pointer_at",
    "register_plugin",
    "sensor_kind",
    "sensor_name",
    "sensor_values",
    "set_word",
    "starts_with",
    "state_of",
    "state_size",
    "store_pointer",
    "word_of",
]
