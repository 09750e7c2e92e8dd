"""The site of the documentation: `make docs` builds it with Sphinx, beside FORD's pages of the core."""
from __future__ import annotations

import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, NumpyDocstring

ROOT = Path(__file__).resolve().parents[1]

# The package is documented as it stands in the repository; what it imports is in .venv, the tools' own packages go first.
PACKAGES = [str(ROOT/"wrappers"), *map(str, sorted(ROOT.glob(".venv/lib/python*/site-packages")))]
sys.path.insert(0, PACKAGES[0])
sys.path += PACKAGES[1:]
os.environ["PYTHONPATH"] = os.pathsep.join(PACKAGES)        # of the notebook

import ldbench  # noqa: E402
from ldbench.case import shortest_name, variables  # noqa: E402

project = "ldbench"
author = "The ldbench authors"
copyright = "The ldbench authors"  # noqa: A001
version = release = ldbench.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_copybutton", "sphinx.ext.mathjax"]
nitpicky = True
# Types of other packages, and private ones of ours, in signatures; they have no pages here.
nitpick_ignore_regex = [("py:.*", r"(?!ldbench\.(Case|ContactTable|Error|Event|Run)$).*")]

# Pages in MyST: equations in dollars, addresses of headings as on GitHub.
myst_enable_extensions = ["amsmath", "attrs_block", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
myst_url_schemes = {"http": None, "https": None, "mailto": None, "module": {"url": "fortran/module/{{path}}.html"},
                    "site": {"url": "{{path}}"}}

# The notebook is run when the site is built, so that its figures are those of the program.
nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_merge_streams = True

# The reference of the package, from its docstrings.
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}       # whose union of types fills a page
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100

html_theme = "furo"
html_title = f"ldbench {release}"
html_show_sphinx = False
html_copy_source = False
# MathJax as one file, so that equations are set without a network.
html_static_path = ["static", str(Path(find_spec("sphinx-mathjax-offline").origin).parent/"static/mathjax/tex-svg.js")]
html_css_files = ["site.css"]
mathjax_path = "tex-svg.js"
html_theme_options = {"navigation_with_keys": True, "footer_icons": []}
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True


def link_pages(app: Sphinx, page: str, source: list[str]) -> None:
    """Links to files of the repository become links to the pages of the site that show them."""
    source[0] = source[0].replace("](../profiles/README.md)", "](reconstruction.md)")
    source[0] = source[0].replace("](../fortran/program/ldbench.f90)", "](site:fortran/program/ldbench.html)")
    source[0] = re.sub(r"\]\(\.\./fortran/(?:\w+/)*(\w+)\.f90\)", r"](module:\1)", source[0])


def skip_variables(app: Sphinx, what: str, name: str, thing: object, skip: bool, options: object) -> bool | None:
    """The variables of a namelist, which are properties of a case, have a page of their own."""
    return True if name in VARIABLES and vars(ldbench.Case).get(name) is thing else None


def hide_signature(app: Sphinx, what: str, name: str, thing: object, options: object, signature: str | None,
                   returns: str | None) -> tuple[str, str | None] | None:
    """Runs are not made by their class."""
    return ("", returns) if name == "ldbench.Run" else None


def take_plain(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Docstrings are plain text with `names` in backticks and indented code, which is nearly, not quite, what Sphinx reads."""
    code, found = False, []
    for k, line in enumerate(lines):
        if line.strip():
            starts = k > 0 and not lines[k - 1].strip() and line.startswith("    ") and not RULE.search("\n".join(lines[:k]))
            if starts and not code:
                found += ["::", ""]
            code = starts or (code and line.startswith("    "))
        found.append(line if code else "``".join(part.strip() if k % 2 else ESCAPED.sub(r"\\\g<0>", part)
                                                 for k, part in enumerate(line.replace("``", "`").split("`"))))
    lines[:] = NumpyDocstring(found, NAPOLEON, app, what, name, thing, options).lines() if RULE.search("\n".join(lines)) else found


NAPOLEON = Config(napoleon_use_rtype=False)
ESCAPED = re.compile(r"[|*]|(?<=\w)_(?!\w)")      # what has a meaning in reStructuredText alone
RULE = re.compile(r"^-{3,}$", re.MULTILINE)       # below the title of a numpydoc section, in which paragraphs are indented
VARIABLES = {shortest_name(k) for k in range(len(variables()))}


def setup(app: Sphinx) -> None:
    app.connect("source-read", link_pages)
    app.connect("autodoc-skip-member", skip_variables)
    app.connect("autodoc-process-docstring", take_plain)
    app.connect("autodoc-process-signature", hide_signature)
