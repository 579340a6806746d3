"""Interface pressure of one periodic cell by finite elements, independently of the spring-block lattice.

A layer 80 um high (nu = 1/4) with square cavities 60 um wide, 20 um deep, 160 um apart slides along x over a rigid plane
under a rigid bulk: u_z = 0 where it touches, friction t_x = -mu p there, u_x = u_y = 0 and equal u_z on top, periodic
along x, mirrored in y at the middle of the cavity and of the land. Trilinear hexahedra of scikit-fem, conjugate gradients
with an algebraic multigrid of pyamg, friction by fixed-point iteration.

    pip install scikit-fem==12.0.2 pyamg==5.4.1
    python cell_pressure.py 5 3.3333333333333335 2.5 > cell_pressure.csv

Prints mean pressures over the nominal one on squares of 10 um, for each element size, and extrapolated from the last two.
"""

import sys

import numpy as np
import pyamg
import scipy.sparse as sp
from skfem import Basis, ElementHex1, ElementVector, MeshHex, asm
from skfem.models.elasticity import lame_parameters, linear_elasticity

PITCH, WIDTH, DEPTH, HEIGHT, PATCH = 160.0, 60.0, 20.0, 80.0, 10.0
NEAR, FAR = (PITCH - WIDTH) / 2, (PITCH + WIDTH) / 2


def pressures(h, coefficients):
    """Patch means of p over P, one array a coefficient of friction."""
    x, y, z = (np.linspace(0, side, round(side / h) + 1) for side in (PITCH, PITCH / 2, HEIGHT))
    mesh = MeshHex.init_tensor(x, y, z)
    cx, cy, cz = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.nonzero((cx > NEAR) & (cx < FAR) & (cy > NEAR) & (cz < DEPTH))[0])
    basis = Basis(mesh, ElementVector(ElementHex1()))
    stiffness = asm(linear_elasticity(*lame_parameters(1.0, 0.25)), basis).tocsr()

    px, py, pz = mesh.p
    dof = basis.nodal_dofs
    close = lambda a, b: np.abs(a - b) < 1e-6
    # Periodic in x: the last plane takes the place of the first.
    order = {(round(b / h), round(c / h)): n for n, (a, b, c) in enumerate(mesh.p.T) if close(a, 0)}
    master = np.arange(stiffness.shape[0])
    for n in np.nonzero(close(px, PITCH))[0]:
        master[dof[:, n]] = dof[:, order[round(py[n] / h), round(pz[n] / h)]]
    mirror = close(py, 0) | close(py, PITCH / 2)
    held = {"top": dof[:, close(pz, HEIGHT)].ravel(), "mirror": dof[1, mirror], "touching": dof[2, close(pz, 0)]}
    fixed = np.zeros(len(master), bool)
    fixed[np.concatenate(list(held.values()))] = True

    free = np.unique(master[~fixed])
    number = -np.ones(len(master), int)
    number[free] = np.arange(len(free))
    rows = np.nonzero(~fixed)[0]
    expand = sp.csr_matrix((np.ones(len(rows)), (rows, number[master[rows]])), (len(master), len(free)))
    at_top = np.zeros(len(master))
    at_top[dof[2, close(pz, HEIGHT)]] = -1.0

    reduced = (expand.T @ stiffness @ expand).tocsr()
    position = np.zeros((3, len(free)))
    component = np.zeros(len(free), int)
    for c in range(3):
        at = number[dof[c]]
        inside = at >= 0
        position[:, at[inside]] = mesh.p[:, inside]
        component[at[inside]] = c
    unit = np.eye(3)[component].T
    bend = np.array([
        unit[2] * position[1] - unit[1] * position[2],
        unit[0] * position[2] - unit[2] * position[0],
        unit[1] * position[0] - unit[0] * position[1],
    ])
    multigrid = pyamg.smoothed_aggregation_solver(reduced, B=np.vstack([unit, bend]).T, max_coarse=500)

    bottom = np.nonzero(close(pz, 0))[0]
    found = []
    u = np.zeros(len(free))
    for mu in coefficients:
        for _ in range(40):
            full = expand @ u + at_top
            normal = (stiffness @ full)[dof[2, bottom]]
            force = np.zeros(len(master))
            # N is positive in compression; friction opposes sliding along x.
            force[dof[0, bottom]] = -mu * normal
            right = expand.T @ (force - stiffness @ at_top)
            residual = np.linalg.norm(right - reduced @ u) / np.linalg.norm(right)
            if residual < 1e-8:
                break
            u = multigrid.solve(right, x0=u, tol=1e-10, accel="cg", maxiter=200)
        mean = np.zeros((round(PITCH / PATCH), round(PITCH / 2 / PATCH)))
        for n, force in zip(bottom, normal):
            # A nodal force spreads over the elements about the node that touch, a quarter of each.
            around = [
                (ex, ey)
                for ex in (px[n] - h / 2, px[n] + h / 2)
                for ey in (py[n] - h / 2, py[n] + h / 2)
                if 0 < ex < PITCH and 0 < ey < PITCH / 2 and not (NEAR < ex < FAR and ey > NEAR)
            ]
            for ex, ey in around:
                mean[int(ex // PATCH), int(ey // PATCH)] += force / len(around)
        found.append(mean / mean.sum() * mean.size)
        print(f"h {h}: mu {mu}, residual {residual:.1e}", file=sys.stderr)
    return np.array(found)


if __name__ == "__main__":
    sizes = [float(size) for size in sys.argv[1:]]
    coefficients = [0.0, 0.27]
    tables = [pressures(h, coefficients) for h in sizes]
    # Pressure at an edge grows with a power of its distance: patch means converge with about the first order.
    (coarse, fine), (before, last) = sizes[-2:], tables[-2:]
    tables.append(last + (last - before) * fine / (coarse - fine))
    print("mu,x_um,y_um," + ",".join(f"h_{size:.3g}" for size in sizes) + ",extrapolated")
    for c, mu in enumerate(coefficients):
        for i, j in np.ndindex(tables[0][c].shape):
            values = [f"{table[c][i, j]:.6f}" for table in tables]
            if float(values[0]) != 0.0:
                print(f"{mu},{(i + 0.5) * PATCH:g},{(j + 0.5) * PATCH:g}," + ",".join(values))
