"""Makes the pages of the examples: `python -m activesuit.tools.example_pages NAME [...]`.

Each program in examples/ runs in an empty folder. Its page, docs/examples/NAME.md, has the text of
its docstring, what the program prints, and the figure that it draws, NAME.png.
"""

import argparse
import ast
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from ..files import write_text

ROOT = Path(__file__).parent.parent
PROGRAMS = ROOT / "examples"
PAGES = ROOT / "docs" / "examples"


def program_names() -> list[str]:
    """Returns the names of the examples, in their order in the menu."""
    return sorted(path.stem for path in PROGRAMS.glob("*.py") if path.stem != "__init__")


def introduction(name: str) -> str:
    """Returns the beginning of a page: the docstring of its program, and the command."""
    source = (PROGRAMS / f"{name}.py").read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    command = f"```bash\npython examples/{name}.py\n```"
    return f"# {title.rstrip('.')}\n\n{text.strip()}\n\n{command}\n"


def make_page(name: str) -> None:
    """Runs an example as a user does without options, and writes its page and its figure."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(PROGRAMS / f"{name}.py")]
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
        page = f"{introduction(name)}\n```text\n{done.stdout.strip()}\n```\n"
        drawn = Path(folder, f"{name}.png")
        if drawn.exists():
            PAGES.mkdir(exist_ok=True)
            shutil.copy(drawn, PAGES / drawn.name)
            page += f"\n![Figure of this program]({drawn.name})\n"
    write_text(PAGES / f"{name}.md", page)


def main() -> None:
    """Makes the pages of the named examples."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="+", choices=program_names(), help="examples to run")
    for name in parser.parse_args().names:
        print(f"examples/{name}.py", flush=True)
        make_page(name)


if __name__ == "__main__":
    main()
