"""The elasticity of wheel and rail as bodies of their own, beside that of half-spaces.

    from ldbench import Case, bodies
    case = Case.exercise(2, "aw")
    bodies.write("aw.bodies", bodies.find(case))
    run = ldbench.run(case.replace(influence="bodies", bodies="aw.bodies"))
"""
from __future__ import annotations

from .influence import Body, find, kept, write
from .sections import Support

__all__ = ["Body", "Support", "find", "kept", "write"]
