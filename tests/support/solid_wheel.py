"""The rim of a wheel in three dimensions, by the tetrahedra of scikit-fem (BSD licence): a judge of elements on the section."""
from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTetP2, ElementVector, FacetBasis, LinearForm, MeshTet, asm
from skfem.models.elasticity import lame_parameters, linear_elasticity

from ldbench.bodies.elements import SYMMETRIC
from ldbench.bodies.mesh import Mesh

# Planes x = const of nodes. Loads end at one of them. The last one is free; a rim of half the length bends by 1 % more [m].
LOADED = 6e-3
PLANES = 1e-3*np.array([0, 2, 4, 6, 8.5, 12, 17, 25, 38, 58, 90, 140, 200])


def influence(mesh: Mesh, held_z: float, poisson: float) -> np.ndarray:
    """E* times the mean displacement of strips by loads of 1 N/m along x, even over the strips, both over |x| < LOADED,
    (strips, strips) [1]. The body is the mesh's, drawn out along x and symmetric to x = 0; it is held on the plane z = held_z."""
    corners, triangles = np.unique(mesh.triangles[:, :3], return_inverse=True)
    flat, n = mesh.points[corners], len(corners)
    triangles = np.sort(triangles.reshape(-1, 3), axis=1)
    points = np.concatenate([np.column_stack([np.full(n, x), flat]) for x in PLANES])
    tetrahedra = []
    for plane in range(len(PLANES) - 1):
        (a, b, c), (d, e, f) = (triangles + plane*n).T, (triangles + (plane + 1)*n).T
        tetrahedra += [(a, b, c, f), (a, b, e, f), (a, d, e, f)]
    solid = MeshTet(np.ascontiguousarray(points.T), np.concatenate([np.array(four) for four in tetrahedra], axis=1))
    basis = Basis(solid, ElementVector(ElementTetP2()))
    stiffness = asm(linear_elasticity(*lame_parameters(1.0, poisson)), basis)
    surface = solid.boundary_facets()
    middles = solid.p[:, solid.facets[:, surface]].mean(axis=1)
    loads = []
    for first, last in mesh.points[mesh.strips[:, [0, 2]]]:
        length = np.linalg.norm(last - first)
        y, z = (last - first)/length
        along, off = np.array([[y, z], [-z, y]]) @ (middles[1:] - first[:, None])
        on_strip = (np.abs(off) < 1e-6) & (along > 0) & (along < length) & (middles[0] > 1e-6) & (middles[0] < LOADED)
        form = LinearForm(lambda v, _, y=y, z=z: -z*v[1] + y*v[2])
        loads.append(asm(form, FacetBasis(solid, basis.elem, facets=surface[on_strip]))/length)
    still = np.union1d(basis.get_dofs(lambda x: np.abs(x[2] - held_z) < 1e-9).all(),
                       basis.get_dofs(lambda x: np.abs(x[0]) < 1e-9).all(["u^1"]))
    free = np.setdiff1d(np.arange(basis.N), still)
    f = np.array(loads).T[free]
    factors = splu(stiffness[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", **SYMMETRIC)
    return f.T @ factors.solve(f)/LOADED/(2*(1 - poisson**2))
