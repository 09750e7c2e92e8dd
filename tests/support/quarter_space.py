"""An elastic quarter-space y > 0, z > 0 under normal loads on z = 0 that are waves cos(kx) along x; the other face is free.

M. Hetenyi's alternation (J. Appl. Mech. 37 (1970) 70-76): loads on one face and their mirror images on a half-space leave no shear
on the other one but a normal stress, which loads on that face take away, and so on. The loads of all turns solve one integral
equation. The normal displacement of a face is that of a half-space under the face's own loads and their images: those of the
other face, which are even beside it, do not move it along its normal.
"""
from __future__ import annotations

import numpy as np
from scipy.special import k0, k1

ORDER = 8           # of Gauss's rule on a panel of a face
FAR = 12.0          # a face ends there [1/k]


def normal_stress(k: float, y: np.ndarray, z: np.ndarray, poisson: float) -> np.ndarray:
    """Stress along y, positive in tension, in a half-space z > 0 under a normal load cos(kx) of 1 N/m on the line y = z = 0.

    By one harmonic function with d2(phi)/dz2 the pressure on the surface (J. R. Barber, Elasticity, Solution F): stress
    z d3(phi)/(dy2 dz) + d2(phi)/dy2 + 2 nu d2(phi)/dx2, with d(phi)/dz = -K0(kr)/pi.
    """
    r = np.hypot(y, z)
    slope = -k*k1(k*r)/r                                    # of K0(kr) over r
    bend = k**2*(k0(k*r) + k1(k*r)/(k*r))                   # its second derivative
    at, weight = np.polynomial.legendre.leggauss(60)
    share = (at + 1)/2
    below = z[..., None] + 40/k*share**3
    phi = np.sum(60/k*share**2*weight*k0(k*np.hypot(y[..., None], below)), axis=-1)/np.pi
    return (-z*(bend*y**2 + slope*z**2)/r**2 + slope*z)/np.pi + (1 - 2*poisson)*k**2*phi


def influence(k: float, strips: int, width: float, poisson: float) -> np.ndarray:
    """E* = E/(2 (1 - nu^2)) times the mean displacement of strips on z = 0, the first one at the edge, by loads of 1 N/m that are
    even over a strip, less what the half-space has by the loads themselves, (strips, strips) [1]."""
    end = strips*width
    edges = np.concatenate([[0], np.geomspace(1e-6*end, width, 14), width*np.arange(2, strips + 1),
                            np.geomspace(end, max(1.5*end, FAR/k), 8)[1:]])
    at, weight = np.polynomial.legendre.leggauss(ORDER)
    size = np.diff(edges)[:, None]
    place, share = (edges[:-1, None] + size*(at + 1)/2).ravel(), (size*weight/2).ravel()
    across = -2*normal_stress(k, *np.broadcast_arrays(place[None, :], place[:, None]), poisson)*share
    first = np.array([(place > j*width) & (place < (j + 1)*width) for j in range(strips)]).T/width
    added = np.linalg.solve(np.eye(len(place)) - across @ across, first) - first
    at, weight = np.polynomial.legendre.leggauss(ORDER + 1)
    middles = (np.arange(strips)[:, None] + (at + 1)/2)*width
    apart, images = np.abs(middles[..., None] - place), middles[..., None] + place
    mean = np.einsum("q,iqa->ia", weight/2, k0(k*images))*share
    both = np.einsum("q,iqa->ia", weight/2, k0(k*apart))*share + mean
    return (mean @ first + both @ added)/np.pi
