"""Times CHOLMOD with METIS on the stiffness of the beam that `benches/factor.rs` factorises.

    apt install libsuitesparse-dev libopenblas-dev
    pip install 'numpy<2' scipy 'scikit-sparse==0.4.16'
    OPENBLAS_NUM_THREADS=2 python cholmod.py

The body is the thesis' beam of 10 x 1 x 1 cm, clamped at x = 0, of linear tetrahedra (six per grid cell, as
`sinew_mesh::box_tetrahedra` makes them) with the stiffness of rest at mu = lambda = 75 kPa. Per size it prints unknowns,
seconds to analyse, to factorise and to solve (the least of three), entries of the factor, and the error of the solution.
"""

import resource
import time
from itertools import permutations

import numpy as np
import scipy.sparse as sparse
from sksparse import cholmod

SIZES = [(12, 4, 5), (40, 13, 17), (60, 20, 25)]
EXTENT = np.array([100.0, 10.0, 10.0])
MU = LAMBDA = 75.0


def mesh(cells):
    nodes = np.array(cells) + 1
    stride = np.array([1, nodes[0], nodes[0] * nodes[1]])
    grid = np.stack(np.meshgrid(*map(np.arange, nodes), indexing="ij"), -1).reshape(-1, 3)
    points = np.empty((len(grid), 3))
    points[grid @ stride] = grid / np.array(cells) * EXTENT
    lowest = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), -1).reshape(-1, 3) @ stride
    tets = [np.stack([lowest + sum(stride[list(order[:k])]) for k in range(4)], 1) for order in permutations(range(3))]
    return points, np.concatenate(tets)


def stiffness(points, tets):
    """Small-strain stiffness of the unclamped unknowns, node by node."""
    edges = points[tets[:, 1:]] - points[tets[:, :1]]
    gradients = np.transpose(np.linalg.inv(edges), (0, 2, 1))
    gradients = np.concatenate([-gradients.sum(1, keepdims=True), gradients], 1)
    volume = abs(np.linalg.det(edges)) / 6
    outer = np.einsum("cai,cbj->caibj", gradients, gradients)
    blocks = LAMBDA * outer + MU * np.einsum("caibj->cajbi", outer)
    trace = np.einsum("caibi->cab", outer)
    blocks += MU * np.einsum("cab,ij->caibj", trace, np.eye(3))
    blocks *= volume[:, None, None, None, None]
    free = np.flatnonzero(points[:, 0] > 0)
    number = np.full(len(points), -1)
    number[free] = np.arange(len(free))
    dof = 3 * number[tets][:, :, None] + np.arange(3)
    rows = np.broadcast_to(dof[:, :, :, None, None], blocks.shape)
    columns = np.broadcast_to(dof[:, None, None, :, :], blocks.shape)
    keep = (number[tets] >= 0)[:, :, None, None, None] & (number[tets] >= 0)[:, None, None, :, None]
    keep = np.broadcast_to(keep, blocks.shape)
    size = 3 * len(free)
    return sparse.csc_matrix((blocks[keep], (rows[keep], columns[keep])), shape=(size, size))


def seconds(action, clock=time.perf_counter, times=3):
    best = np.inf
    for _ in range(times):
        start = clock()
        action()
        best = min(best, clock() - start)
    return best


def main():
    for cells in SIZES:
        matrix = stiffness(*mesh(cells))
        start = time.perf_counter()
        factor = cholmod.analyze(matrix, mode="supernodal", ordering_method="metis")
        analysed = time.perf_counter() - start
        factorised = seconds(lambda: factor.cholesky_inplace(matrix))
        processor = seconds(lambda: factor.cholesky_inplace(matrix), time.process_time)
        expected = np.arange(matrix.shape[0]) % 11 - 4.5
        right = matrix @ expected
        solved = seconds(lambda: factor(right))
        error = np.abs(matrix @ factor(right) - right).max() / np.abs(right).max()
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
        print(
            f"{cells}: {matrix.shape[0]} unknowns; analyse {analysed:.4f} s, factorise {factorised:.4f} s "
            f"(processor time {processor:.2f} s), "
            f"solve {solved:.4f} s; factor {factor.L().nnz / 1e6:.2f} M entries; residual {error:.1e}; "
            f"peak memory {memory:.0f} MB"
        )


if __name__ == "__main__":
    main()
