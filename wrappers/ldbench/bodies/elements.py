"""Elastic bodies that do not change along x: displacements by loads that are waves along x.

With loads proportional to cos(kx) the displacements along x, y, z are u sin(kx), v cos(kx), w cos(kx), and u, v, w are functions on
the section: the energy of a wave is that of real, symmetric matrices K0 + k K1 + k^2 K2. Triangles with six nodes; a rule of six
points, exact to the fourth degree (D. A. Dunavant, Int. J. Numer. Methods Eng. 21 (1985) 1129-1148).
"""
from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from .._core.errors import Error
from .mesh import Mesh

A, B = 0.445948490915965, 0.091576213509771
RULE = np.array([(1 - 2*A, A), (A, 1 - 2*A), (A, A), (1 - 2*B, B), (B, 1 - 2*B), (B, B)])
SYMMETRIC = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
WEIGHTS = np.array([0.223381589678011]*3 + [0.109951743655322]*3)/2


def shape_functions(a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    """Values (6) and derivatives (2, 6) at the barycentric coordinates a, b of the second and third corner."""
    c = 1 - a - b
    values = np.array([c*(2*c - 1), a*(2*a - 1), b*(2*b - 1), 4*a*b, 4*b*c, 4*c*a])
    slopes = np.array([[1 - 4*c, 4*a - 1, 0, 4*b, -4*b, 4*(c - a)], [1 - 4*c, 0, 4*b - 1, 4*a, 4*(c - b), -4*a]])
    return values, slopes


def stiffness(mesh: Mesh, poisson: float) -> list[csc_matrix]:
    """K0, K1, K2 for Young's modulus 1."""
    n = len(mesh.triangles)
    corners = mesh.points[mesh.triangles[:, :3]]
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=1)        # (n, 2, 2)
    area, inverse = np.linalg.det(edges), np.linalg.inv(edges)
    lame = poisson/((1 + poisson)*(1 - 2*poisson))
    shear = 1/(2*(1 + poisson))
    law = np.diag([lame + 2*shear]*3 + [shear]*3)
    law[:3, :3] += lame - np.diag([lame]*3)
    parts = np.zeros((3, n, 18, 18))
    for (a, b), weight in zip(RULE, WEIGHTS, strict=True):
        values, slopes = shape_functions(a, b)
        y, z = np.moveaxis(inverse @ slopes, 1, 0)                                                  # (n, 6)
        # Strains xx, yy, zz, yz, xy, zx by node and direction.
        even, waved = np.zeros((n, 6, 6, 3)), np.zeros((1, 6, 6, 3))
        even[:, 1, :, 1], even[:, 2, :, 2] = y, z
        even[:, 3, :, 1], even[:, 3, :, 2] = z, y
        even[:, 4, :, 0], even[:, 5, :, 0] = y, z
        waved[:, 0, :, 0], waved[:, 4, :, 1], waved[:, 5, :, 2] = values, -values, -values
        flat, wave = even.reshape(n, 6, 18), np.broadcast_to(waved.reshape(1, 6, 18), (n, 6, 18))
        size = weight*area[:, None, None]
        stress = law @ flat*size
        turned = np.swapaxes(wave, 1, 2)
        mixed = turned @ stress
        parts[0] += np.swapaxes(flat, 1, 2) @ stress
        parts[1] += mixed + np.swapaxes(mixed, 1, 2)
        parts[2] += turned @ (law @ wave*size)
    place = (3*mesh.triangles[:, :, None] + np.arange(3)).reshape(n, 18)
    rows, columns = np.repeat(place, 18, axis=1).ravel(), np.tile(place, (1, 18)).ravel()
    shape = (3*len(mesh.points),)*2
    return [csc_matrix((part.ravel(), (rows, columns)), shape=shape) for part in parts]


def loads(mesh: Mesh) -> np.ndarray:
    """Loads of 1 N/m into the body, along the normal of each strip and even over it, (degrees of freedom, strips)."""
    f = np.zeros((3*len(mesh.points), len(mesh.strips)))
    first, _, last = mesh.points[mesh.strips].transpose(1, 0, 2)
    along = (last - first)/np.linalg.norm(last - first, axis=1)[:, None]
    into = np.column_stack([-along[:, 1], along[:, 0]])
    for k, share in enumerate((1/6, 4/6, 1/6)):
        for axis in range(2):
            np.add.at(f, (3*mesh.strips[:, k] + 1 + axis, np.arange(len(mesh.strips))), share*into[:, axis])
    return f


def influences(mesh: Mesh, poisson: float, waves: np.ndarray) -> np.ndarray:
    """Mean displacement of every strip into the body by the loads of every strip, (waves, strips, strips), for E = 1 Pa."""
    parts, f = stiffness(mesh, poisson), loads(mesh)
    still = np.zeros(len(f), bool)
    still[(3*mesh.held[:, None] + np.arange(3)).ravel()] = True
    loaded = np.any(f != 0, axis=1) & ~still
    inner = np.flatnonzero(~loaded & ~still)
    first = splu(sum(parts)[inner][:, inner].tocsc(), **SYMMETRIC, permc_spec="MMD_AT_PLUS_A")
    order = np.concatenate([inner[np.argsort(first.perm_c)], np.flatnonzero(loaded)])
    ordered, f = [part[order][:, order] for part in parts], f[loaded]
    return np.array([f.T @ np.linalg.solve(condensed(ordered[0] + k*ordered[1] + k**2*ordered[2], len(f)), f) for k in waves])


def condensed(matrix: csc_matrix, n: int) -> np.ndarray:
    """The stiffness that the last n unknowns have where the others are free: the last block of the triangular factors."""
    factors = splu(matrix.tocsc(), **SYMMETRIC, permc_spec="NATURAL")
    last = factors.perm_c[-n:]
    if last.min() < matrix.shape[0] - n:
        raise Error(expected="factors in the order of the unknowns", found="another order", place="bodies")
    block = factors.L[-n:, -n:].toarray() @ factors.U[-n:, -n:].toarray()
    last = last - last.min()
    return block[np.ix_(last, last)]
