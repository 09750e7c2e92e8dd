# The extension has one module, of which flat.pyi has the types.
from . import flat as flat
