# The procedures of flat.f90, as f2py makes them.
from typing import Any

def __getattr__(name: str) -> Any: ...
