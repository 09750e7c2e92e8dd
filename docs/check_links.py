"""Check the links between the pages of a site: `python docs/check_links.py build/docs`. Nothing is asked of the network."""
from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The links of a page, and the names in it that links may lead to."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.links.append(value)
            elif name in ("id", "name") and value:
                self.names.add(value)


def broken(site: Path) -> list[str]:
    """The links of the site's own pages that lead nowhere; FORD's pages may be led to."""
    pages = {file: Page(file) for file in sorted(site.glob("*.html"))}
    found = []
    for file, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent/unquote(parts.path)).resolve() if parts.path else file.resolve()
            if not target.exists():
                found.append(f"{file.name}: {link}: no such file")
            elif parts.fragment and target.suffix == ".html":
                other = pages.get(target) or Page(target)
                if unquote(parts.fragment) not in other.names:
                    found.append(f"{file.name}: {link}: no such place in the page")
    return found


if __name__ == "__main__":
    found = broken(Path(sys.argv[1]).resolve())
    print(*found, sep="\n", end="\n" if found else "", file=sys.stderr)
    sys.exit(bool(found))
