"""Both problems by a Gaussian process whose functions satisfy the conditions, in JAX.

Features and mean are written for each problem, derivatives are JAX's; the equation counts for one value, as in the crate.
One problem a line as JSON on standard input; estimate, interval, seconds and u on the grid on standard output."""

import json, sys, time
import jax, jax.numpy as jnp, numpy as np
from scipy.optimize import minimize

jax.config.update("jax_enable_x64", True)


def square(x, y, lengths):
    return jnp.exp(-0.5 * jnp.sum(((x - y) / lengths) ** 2))


class Slab:
    """sealed at x = 0, zero at x = 1, cos(pi x / 2) at t = 0"""
    lengths = 3  # of both features
    mean = staticmethod(lambda x: jnp.cos(jnp.pi * x[0] / 2))

    @staticmethod
    def kernel(x, y, p):
        phi = lambda x: 27 / 4 * x[0] ** 2 * (1 - x[0]) * x[1]
        trace = lambda x: (1 - 3 * x[0] ** 2 + 2 * x[0] ** 3) * x[1]
        first = jnp.exp(2 * p[0]) * square(x, y, jnp.exp(p[2:4]))
        second = jnp.exp(2 * p[1]) * square(x[1:], y[1:], jnp.exp(p[4:5]))
        return phi(x) * phi(y) * first + trace(x) * trace(y) * second

    amplitudes = 2

    @staticmethod
    def operator(u, theta):
        return lambda x: jax.grad(u)(x)[1] - theta * jax.hessian(u)(x)[0, 0]


class Beam:
    """clamped at both ends"""
    lengths, amplitudes = 1, 1
    mean = staticmethod(lambda x: 0.0 * x[0])

    @staticmethod
    def kernel(x, y, p):
        phi = lambda x: 16 * x[0] ** 2 * (1 - x[0]) ** 2
        return phi(x) * phi(y) * jnp.exp(2 * p[0]) * square(x, y, jnp.exp(p[1:2]))

    @staticmethod
    def operator(u, theta):
        along = lambda f: lambda s: jax.jvp(f, (s,), (1.0,))[1]
        def apply(x):
            f = lambda s: u(jnp.array([s]))
            return theta * along(along(along(along(f))))(x[0]) + 300.0 * u(x)
        return apply


def covariances(problem, p, theta):
    """of u with u, f with u and f with f"""
    k = lambda x, y: problem.kernel(x, y, p)
    fu = lambda x, y: problem.operator(lambda x: k(x, y), theta)(x)
    ff = lambda x, y: problem.operator(lambda y: fu(x, y), theta)(y)
    return [jax.vmap(jax.vmap(f, (None, 0)), (0, None)) for f in (k, fu, ff)]


def factored(problem, q, data):
    places, values, points, loads = data
    count = problem.amplitudes + problem.lengths
    p, theta, sigma = q[:count], jnp.exp(q[count]), jnp.exp(q[count + 1])
    k, fu, ff = covariances(problem, p, theta)
    cross = fu(points, places)
    K = jnp.block([[ff(points, points), cross], [cross.T, k(places, places)]])
    noise = jnp.r_[jnp.zeros(len(points)), jnp.full(len(places), sigma**2)]
    L = jnp.linalg.cholesky(K + jnp.diag(1e-10 * jnp.diag(K) + noise))
    mean = jax.vmap(problem.mean)
    rest = jnp.r_[loads - jax.vmap(problem.operator(problem.mean, theta))(points), values - mean(places)]
    return L, jax.scipy.linalg.solve_triangular(L, rest, lower=True)


def objective(problem, q, data, scale):
    L, z = factored(problem, q, data)
    rows = 0.5 * z**2 + jnp.log(jnp.diag(L))
    n = len(data[2])
    count, amplitudes = problem.amplitudes + problem.lengths, problem.amplitudes
    prior = 0.5 * jnp.sum((q[:amplitudes] - jnp.log(scale)) ** 2) + 0.5 * jnp.sum(q[amplitudes:count] ** 2)
    noise = 0.5 * ((q[count + 1] - jnp.log(0.05 * scale)) / 1.5) ** 2
    return jnp.sum(rows[n:]) + jnp.sum(rows[:n]) / n + prior + noise


def predicted(problem, q, data, grid):
    L, z = factored(problem, q, data)
    count = problem.amplitudes + problem.lengths
    k, fu, _ = covariances(problem, q[:count], jnp.exp(q[count]))
    cross = jnp.concatenate([fu(data[2], grid), k(data[0], grid)])
    return jax.vmap(problem.mean)(grid) + jax.scipy.linalg.solve_triangular(L, cross, lower=True).T @ z


compiled = {}
for line in sys.stdin:
    given = json.loads(line)
    name, problem = given["problem"], {"slab": Slab, "beam": Beam}[given["problem"]]
    data = [jnp.array(given[key]) for key in ("places", "values", "points", "loads")]
    clock = time.perf_counter()
    scale = jnp.std(data[1])
    if name not in compiled:
        own = lambda q, data, scale, problem=problem: objective(problem, q, data, scale)
        compiled[name] = jax.jit(jax.value_and_grad(own)), jax.jit(lambda *all, problem=problem: predicted(problem, *all))
    value, predict = compiled[name]
    count = problem.amplitudes + problem.lengths
    best = None
    for seed in range(4):
        random = np.random.default_rng(seed)
        start = np.r_[np.log(float(scale)) + random.uniform(-1, 1, problem.amplitudes),
                      random.uniform(-1, 0.4, problem.lengths), random.uniform(-2, 1), np.log(0.03 * float(scale))]
        found = minimize(lambda q: [np.nan_to_num(np.asarray(v, float), nan=1e10) for v in value(q, data, scale)],
                         start, jac=True, method="L-BFGS-B", bounds=[(s - 5, s + 5) for s in start], options={"maxiter": 100})
        best = found if best is None or found.fun < best.fun else best
    q = jnp.array(best.x)
    slope = lambda q: np.asarray(value(jnp.array(q), data, scale)[1])
    hessian = np.array([(slope(best.x + h) - slope(best.x - h)) / 2e-3 for h in 1e-3 * np.eye(len(best.x))])
    width = 1.96 * np.sqrt(np.linalg.inv(0.5 * (hessian + hessian.T))[count, count])
    u = predict(q, data, jnp.array(given["grid"]))
    seconds = time.perf_counter() - clock
    print(*np.exp([q[count], q[count] - width, q[count] + width]), seconds, *np.asarray(u), flush=True)
