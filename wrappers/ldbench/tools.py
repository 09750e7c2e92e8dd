"""Files, worker processes and words for packages on top of ldbench."""
from __future__ import annotations

from ._core.errors import Usage
from ._core.files import check_ending, check_written, complete, digest, make_results_folder, read_bytes, write_frame
from ._core.kept import kept_in, program_digest
from ._core.pools import PROCESS_DIED, processes, usable_cores
from ._core.wording import counted

__all__ = ["PROCESS_DIED", "Usage", "check_ending", "check_written", "complete", "counted", "digest", "kept_in",
           "make_results_folder", "processes", "program_digest", "read_bytes", "usable_cores", "write_frame"]
