"""The pages of the tutorials: how they are made, and that they have the code of their programs."""

import re

import pytest
from activesuit.errors import InputError
from activesuit.tools.tutorials import FOLDER, VARIES, cells, differences, execute, page, write

PROGRAM = """# %% [markdown]
# # Title
#
# See [the program](1_tiny.py).

# %%
import matplotlib.pyplot as plt

numbers = [1.0, 2.5]
print(*numbers, sep="\\n")

# %%
plt.subplots(num="Two numbers")[1].plot(numbers)
plt.show()

# %% tags=["varies"]
print(max(numbers))
"""
PAGE = """<!-- made by tutorials.py from 1_tiny.py -->

# Title

See [the program](1_tiny.py).

```python
import matplotlib.pyplot as plt

numbers = [1.0, 2.5]
print(*numbers, sep="\\n")
```

``` { .text .output }
1.0
2.5
```

```python
plt.subplots(num="Two numbers")[1].plot(numbers)
plt.show()
```

![Two numbers](figures/1_tiny-1-light.svg#gh-light-mode-only)

![Two numbers](figures/1_tiny-1-dark.svg#gh-dark-mode-only)

```python
print(max(numbers))
```

``` { .text .varies }
2.5
```
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with one small tutorial, of which the tool makes the page."""
    (tmp_path / "1_tiny.py").write_text(PROGRAM)

    write(tmp_path)
    return tmp_path


def test_a_page_has_cells_outputs_and_figures_for_light_and_dark(folder):
    assert (folder / "1_tiny.md").read_text() == PAGE
    light, dark = (folder / f"figures/1_tiny-1-{mode}.svg" for mode in ("light", "dark"))
    assert "#31353b" in light.read_text()
    assert "#31353b" not in dark.read_text()
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*.*")}
    write(folder, check=True)  # writes nothing
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("*.*")} == before


def test_a_check_fails_where_the_output_or_the_code_is_another(folder):
    kept = folder / "1_tiny.md"
    kept.write_text(PAGE.replace("2.5\n```\n\n```python\nplt", "2.8\n```\n\n```python\nplt"))
    with pytest.raises(SystemExit, match=r"'2\.5', and '2\.8' is kept"):
        write(folder, check=True)
    kept.write_text(PAGE)
    (folder / "1_tiny.py").write_text(PROGRAM.replace("print(max(", "print(min("))
    with pytest.raises(SystemExit, match=r"'print\(min\(numbers\)\)', and 'print\(max"):
        write(folder, check=True)


def test_an_error_in_a_cell_ends_the_tool_and_names_the_line(folder):
    (folder / "1_tiny.py").write_text(PROGRAM.replace("max(numbers)", "max(letters)"))
    with pytest.raises(NameError, match="letters") as error:
        write(folder, check=True)
    assert error.traceback[-1].lineno + 1 == len(PROGRAM.splitlines())


@pytest.mark.parametrize(
    ("old", "new", "alike"),
    [
        ("relief 0.926 (0.883)", "relief 0.927 (0.876)", True),
        ("relief 0.926", "relief 0.946", False),
        ("took 102 steps", "took 103 steps", True),
        ("took 102 steps", "took 105 steps", False),
        ("error -0.00 N·m", "error 0.00 N·m", True),
        ("valid 0.5", "not valid 0.5", False),
        ("1.0 2.0", "1.0", False),
        (PAGE, PAGE.replace(".varies }\n2.5", ".varies }\n3\nand more"), True),
    ],
)
def test_numbers_may_differ_in_the_last_digit_or_by_one_percent(old, new, alike):
    assert (list(differences(old, new)) == []) is alike


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("print(1)\n# %%\n", "begin it with '# %%'"),
        ("# %% [markdown]\n# Title\nprint(1)\n", "line 3 is no comment"),
    ],
)
def test_a_program_that_is_no_tutorial_is_refused(script, said):
    with pytest.raises(InputError, match=said):
        cells(script)


def test_a_figure_needs_a_name():
    with pytest.raises(InputError, match="line 2: give the figure a name"):
        execute("tiny", "# %%\nimport matplotlib.pyplot as plt; plt.plot([1, 2])\n")


SHOWN = re.compile(r"^``` \{ \.text \.\w+ \}\n.*?^```\n|^!\[[^\n]*\n", re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_a_page_is_its_program_with_what_it_showed(path):
    script = path.read_text(encoding="utf-8")
    kept = path.with_suffix(".md").read_text(encoding="utf-8")
    code = [cell for cell in cells(script) if cell.is_code]
    plain = page(path.stem, script, [""] * len(code))
    assert SHOWN.sub("", kept).split() == plain.split(), "python -m activesuit.tools.tutorials"
    figures = {name.partition("#")[0] for name in re.findall(r"\]\((figures/[^)]+)", kept)}
    drawn = {f"figures/{one.name}" for one in (FOLDER / "figures").glob(f"{path.stem}-*")}
    assert figures == drawn
    assert kept.count("{ .text .varies }") == sum(cell.varies for cell in code), VARIES
