"""What the page of every run has to hold, for the tests of the commands that write one."""

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path

from activesuit.scripts.folders import RunFolder
from activesuit.scripts.html.loops import FILE, HEADER
from activesuit.scripts.html.writing import report_page, write_report

LARGEST = 8_000_000  # bytes
LOADING = ("src", "href", "srcset", "action", "poster", "data", "xlink:href", "formaction")
VOID = {"meta", "input", "img", "br", "link"}
EVIL = (
    "<script>window.hacked=1</script>",
    "</script><img src=x onerror=window.hacked=1>",
    "\"' onmouseover='window.hacked=1'",
    "<!-- <b>&amp;&lt;",
    "first\nsecond",
    "\u202egnp.exe\u2066",
    "\x1b[2J\0",
)


@dataclass
class Page(HTMLParser):
    """The elements of a page, with their attributes and all text.

    Attributes:
        elements: Names and attributes of the elements, in order.
        texts: Text outside of scripts and styles.
        scripts: Contents of the scripts, by their type; "" for those that run.
        open: Names of the elements that are open; empty at the end of a page that is well formed.
    """

    elements: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    scripts: list[tuple[str, str]] = field(default_factory=list)
    open: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append((dict(attrs).get("type") or "", ""))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["script"]:
            kind, before = self.scripts[-1]
            self.scripts[-1] = kind, before + data
        elif self.open[-1:] != ["style"]:
            self.texts.append(data)

    @property
    def text(self) -> str:
        """Text that a reader sees."""
        return " ".join(" ".join(self.texts).split())

    def all(self, name: str) -> list[dict[str, str | None]]:
        """Attributes of all elements of a name."""
        return [attributes for tag, attributes in self.elements if tag == name]


def parsed(path: Path) -> Page:
    """The elements of a page."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    page.close()
    assert page.open == []
    return page


def checked_page(folder: Path) -> Page:
    """The page of a run: small, complete, accessible, offline, and the same when made again."""
    path = folder / "report.html"
    before = path.read_bytes()
    assert len(before) < LARGEST
    assert report_page(folder).encode() == before
    page = parsed(path)
    for _, attributes in page.elements:
        for name in LOADING:
            assert (attributes.get(name) or "#").startswith(("#", "data:image/png;base64,"))
    identities = [one["id"] for _, one in page.elements if "id" in one]
    assert len(set(identities)) == len(identities)
    assert all(one.get("alt") for one in page.all("img"))
    assert all(one.get("aria-label") for _, one in page.elements if one.get("role") == "img")
    assert len(page.all("caption")) == len(page.all("table"))
    assert len(page.all("h1")) == 1
    targets = {f"#{identity}" for identity in identities}
    assert {one["href"] for one in page.all("a")} <= targets
    labelled = {one["for"] for one in page.all("label")}
    assert {one["id"] for name in ("input", "select") for one in page.all(name)} <= labelled
    return page


def evil_run(folder, names=EVIL):
    """Writes a report in which everything that a user can name has one of these names."""
    angles = (0.5, 1.0, 1.5, 1.0, 0.5)
    run = RunFolder(folder)
    run.csv(FILE, HEADER, ([name, name, "fit", x, x**2, x, 0, 2] for name in names for x in angles))
    write_report(
        *(run, "rig", " ".join(names)),
        answer=names,
        tables={name: ([name, "n"], [[name, "1"], [name, "2"]]) for name in names},
        settings={name: name for name in names} | {"nested": {name: [name] for name in names}},
    )
    run.close()
    return folder


def seen(name):
    """A name as the page shows it: characters that cannot be seen as Python writes them."""
    shown = name.replace("\u202e", "\\u202e").replace("\u2066", "\\u2066")
    return " ".join(shown.replace("\x1b", "\\x1b").replace("\0", "\\x00").split())
