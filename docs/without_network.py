"""Give the pages of FORD their styles from this machine: `python docs/without_network.py build/docs/fortran`.

FORD's pages ask a server for Bootstrap and for MathJax. Bootstrap is copied from the package Bootstrap-Flask; MathJax goes, because
comments of the core have no equations that it sets.
"""
from __future__ import annotations

import re
import sys
from importlib.util import find_spec
from pathlib import Path

# By the names that FORD's pages have for them: what they are made of.
BOOTSTRAP = {"css/bootstrap.min.css": ["css/bootstrap.min.css"],
             "js/bootstrap.bundle.min.js": ["umd/popper.min.js", "js/bootstrap.min.js"]}
REMOTE = re.compile(r'https://cdn\.jsdelivr\.net/npm/bootstrap@[\d.]+/dist/((?:css|js)/[\w.]+)"\s+(rel="stylesheet")?\s*'
                    r'integrity="[^"]*" crossorigin="anonymous"')
MATHJAX = re.compile(r"<!-- MathJax -->.*?(?=<!-- Other scripts)", re.DOTALL)


def main(site: Path) -> int:
    """Copy the files, and let all pages ask for them."""
    source = Path(find_spec("flask_bootstrap").origin).parent/"static/bootstrap5"
    for name, parts in BOOTSTRAP.items():
        (site/name).write_text("\n".join((source/part).read_text(encoding="utf-8") for part in parts), encoding="utf-8")
    for page in site.rglob("*.html"):
        up = "../"*(len(page.relative_to(site).parts) - 1)
        text = page.read_text(encoding="utf-8")
        text = REMOTE.sub(lambda found, up=up: f'{up}{found[1]}" {found[2] or ""}', MATHJAX.sub("", text))
        if "cdn.jsdelivr" in text:
            print(f"docs: {page}: expected no style or script of a server, found one", file=sys.stderr)
            return 1
        page.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
