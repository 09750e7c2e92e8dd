"""Write the reference package.

    python docs/reference_package.py [ZIP]      outputs/ldbench_reference.zip without a name, in about two minutes
"""
from __future__ import annotations

import sys
from pathlib import Path

from ldbench import Error
from ldbench_round.reference_package import write_package

ROOT = Path(__file__).resolve().parents[1]


def main(words: list[str]) -> int:
    target = Path(words[0]) if words else Path("outputs/ldbench_reference.zip")
    try:
        write_package(target, ROOT, told=print)
    except Error as error:
        print(f"docs: {error}", file=sys.stderr)
        return 1
    print(f"{target}: {target.stat().st_size/1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
