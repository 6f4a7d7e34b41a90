#!/usr/bin/env python3
"""View factors of a cube by pyviewfactor and by zonal, in one run: time and difference.

    pip install pyviewfactor numpy
    cargo build --release
    python peers/pyviewfactor_cube.py [--zonal target/release/zonal] [--patches 10] [--rotated]

The cube has N×N patches a wall; with --rotated it is turned at random and every patch is split into two triangles, so that no lattice is left. zonal is
timed as a whole process (`zonal exchange --direct-only`, reading, computing, writing: the same factors, no reflections), by the processor time that the system accounts to it; pyviewfactor is timed
inside the process, its just-in-time compilation done beforehand on a small cube. The difference is that of the two matrices; rows of a closed cube
sum to one, which says how far each is off.
"""

import pathlib
import tempfile

import numpy as np

from shared import cost, head, parser, row, seconds_of


def corners(n, rotated):
    """The patches of the unit cube, normals inwards: a list of arrays of 3 or 4 corners."""
    turn = np.eye(3)
    if rotated:
        turn, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
    out = []
    for axis in range(3):
        for side in (0, 1):
            for i in range(n):
                for j in range(n):
                    def at(u, v):
                        x = np.zeros(3)
                        x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3] = side, u / n, v / n
                        return turn @ x
                    c = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                    c = c if side == 0 else c[::-1]
                    out += [c[:3], [c[0], c[2], c[3]]] if rotated else [c]
    return [np.array(c) for c in out]


def by_zonal(program, faces, folder):
    """Matrix of F(i → j), processor seconds."""
    lines, k = [], 1
    for c in faces:
        lines += ["v " + " ".join(repr(float(x)) for x in p) for p in c]
        lines.append("f " + " ".join(str(k + i) for i in range(len(c))))
        k += len(c)
    (folder / "cube.obj").write_text("\n".join(lines) + "\n")
    (folder / "cube.toml").write_text('[solve]\npatch_size = 10\n[[surface]]\nname = "cube"\nmesh = { file = "cube.obj" }\n')
    seconds, _ = cost([program, "exchange", folder / "cube.toml", "-o", folder / "f.npz", "--direct-only", "--quiet"])
    z = np.load(folder / "f.npz")
    return z["exchange_areas"][0] / z["closure"][0][:, None], seconds


def by_pyviewfactor(faces):
    """Matrix of F(i → j), seconds, threads."""
    import numba
    import pyviewfactor
    import pyvista

    def mesh(faces):
        cells, k = [], 0
        for c in faces:
            cells += [len(c), *range(k, k + len(c))]
            k += len(c)
        return pyvista.PolyData(np.concatenate(faces), faces=cells)

    def matrix(m):
        return pyviewfactor.compute_viewfactor_matrix(m, skip_obstruction=True, rounding_decimal=15)

    matrix(mesh(corners(2, len(faces[0]) == 3)))
    f, seconds = seconds_of(lambda: matrix(mesh(faces)))
    return f.T, seconds, numba.get_num_threads()


def main():
    p = parser(__doc__)
    p.add_argument("--patches", type=int, default=10)
    p.add_argument("--rotated", action="store_true")
    args = p.parse_args()
    faces = corners(args.patches, args.rotated)
    with tempfile.TemporaryDirectory() as folder:
        ours, seconds = by_zonal(args.zonal, faces, pathlib.Path(folder))
    theirs, slow, threads = by_pyviewfactor(faces)
    pairs = len(faces) * (len(faces) - 1) / 2
    head("", "zonal", "pyviewfactor")
    row(f"processor time, s ({len(faces)} patches)", f"{seconds:.3f}", f"{slow:.3f} ({threads} threads)")
    row("µs a pair", *(f"{1e6 * t / pairs:.2f}" for t in (seconds, slow)))
    row("largest |row sum − 1|", *(f"{abs(f.sum(1) - 1).max():.1e}" for f in (ours, theirs)))
    print(f"\nlargest difference of a view factor: {abs(ours - theirs).max():.1e}; ratio of times: {slow / seconds:.0f}")


if __name__ == "__main__":
    main()
