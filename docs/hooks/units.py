"""Keeps units in docstrings, as in `angle[0] [rad]`, from being read as links."""

import griffe


class Units(griffe.Extension):
    """Writes a bracket that follows another one as an entity."""

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Changes the docstring of anything that has one."""
        if obj.docstring:
            obj.docstring.value = obj.docstring.value.replace("] [", "] &#91;")
