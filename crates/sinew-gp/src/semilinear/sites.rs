//! Normal approximations: a normal prior times Gaussian factors, each of a few values.

use crate::buffer::Buffer;
use crate::factor::Factor;
use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{ColRef, Mat, MatRef, Par, Side};

/// Values that are normal before anything is known of them.
pub(crate) struct Normal {
    pub mean: Vec<f64>,
    pub covariance: Mat<f64>,
}

/// A Gaussian factor exp(−½ ‖Rᵀd − t‖² / σ²) of the values in some rows, its precision and pull in
/// units of a noise σ.
#[derive(Clone, Debug)]
pub(crate) struct Site {
    pub rows: Vec<usize>,
    /// R, square.
    root: Mat<f64>,
    /// t
    target: Vec<f64>,
    /// σ
    pub sigma: f64,
}

/// Share of the largest eigenvalue of a precision that smaller or negative ones are raised to.
const LEAST_PRECISION: f64 = 1e-12;

impl Site {
    /// exp(−½ (d − y)² / σ²)
    pub fn observed(row: usize, y: f64, sigma: f64) -> Self {
        Self { rows: vec![row], root: Mat::identity(1, 1), target: vec![y], sigma }
    }

    /// exp((λᵀd − ½ dᵀΛd) / σ²). A precision Λ that is not definite is replaced by the nearest that
    /// is, and none comes of one that is not finite; `pull` makes λ from what is left of Λ.
    pub fn new(
        rows: &[usize],
        precision: &Mat<f64>,
        pull: impl Fn(&Mat<f64>) -> Vec<f64>,
        sigma: f64,
    ) -> Option<Self> {
        let size = rows.len();
        let eigen = SelfAdjointEigen::new(precision.as_ref(), Side::Lower).ok()?;
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let most = (0..size).fold(0.0, |most: f64, k| most.max(values[k]));
        if most <= 0.0 || !most.is_finite() {
            return None;
        }
        let roots: Vec<f64> =
            (0..size).map(|k| values[k].max(LEAST_PRECISION * most).sqrt()).collect();
        let root = Mat::from_fn(size, size, |row, k| vectors[(row, k)] * roots[k]);
        let linear = pull(&(&root * root.transpose()));
        let target = (0..size)
            .map(|k| vectors.col(k).iter().zip(&linear).map(|(v, l)| v * l).sum::<f64>() / roots[k])
            .collect();
        Some(Self { rows: rows.to_vec(), root, target, sigma })
    }

    /// The same in units of another noise.
    pub fn with_noise(&self, sigma: f64) -> Self {
        Self { sigma, ..self.clone() }
    }

    /// σ² times the precision.
    pub fn precision(&self) -> Mat<f64> {
        &self.root * self.root.transpose()
    }

    /// σ² times the linear part.
    fn linear(&self) -> Vec<f64> {
        let row =
            |row: usize| self.root.row(row).iter().zip(&self.target).map(|(r, t)| r * t).sum();
        (0..self.rows.len()).map(row).collect()
    }

    /// The part `share` of the way to another factor of the same values.
    pub fn towards(&self, other: &Self, share: f64) -> Option<Self> {
        let (own, its) = (self.precision(), other.precision());
        let blend = |a: f64, b: f64| (1.0 - share) * a + share * b;
        let precision =
            Mat::from_fn(own.nrows(), own.ncols(), |i, j| blend(own[(i, j)], its[(i, j)]));
        let linear =
            self.linear().iter().zip(&other.linear()).map(|(a, b)| blend(*a, *b)).collect();
        Self::new(&self.rows, &precision, move |_| Vec::clone(&linear), self.sigma)
    }
}

/// q = N(a, S), proportional to a prior N(m, K) times sites.
pub(crate) struct Approximation {
    /// a
    pub mean: Vec<f64>,
    /// w = K⁻¹ (a − m)
    pub weights: Vec<f64>,
    /// T, with S = K − (TK)ᵀ TK
    pub whitening: Mat<f64>,
    /// TK
    whitened: Mat<f64>,
    /// Divergence of Kullback and Leibler from prior to q
    pub divergence: f64,
}

/// What an objective of q changes by with the mean and covariance of some values.
pub(crate) struct Pull {
    pub mean: Vec<f64>,
    pub covariance: Mat<f64>,
}

/// What the objective less the divergence changes by, the sites being held.
pub(crate) struct Slopes {
    /// With the prior's mean.
    pub mean: Vec<f64>,
    /// With the prior's covariance: symmetric, as if all its entries were independent.
    pub covariance: Mat<f64>,
    /// With the logarithm of each site's σ, by way of q.
    pub sigma: Vec<f64>,
}

impl Approximation {
    /// None if the covariance of the values as the sites weigh them cannot be factorised.
    pub fn new(prior: &Normal, sites: &[Site]) -> Option<Self> {
        let size = prior.mean.len();
        // Rᵀ K R + I = L Lᵀ, whose eigenvalues are one or more: K itself may be singular.
        let mut scaled = Mat::<f64>::zeros(size, size);
        let mut misfit = vec![0.0; size];
        let mut next = 0;
        for site in sites {
            for k in 0..site.rows.len() {
                let column = next + k;
                misfit[column] = site.target[k];
                for (row, r) in site.rows.iter().zip(site.root.col(k).iter()) {
                    scaled[(*row, column)] = r / site.sigma;
                    misfit[column] -= r * prior.mean[*row];
                }
                misfit[column] /= site.sigma;
            }
            next += site.rows.len();
        }
        let product = &prior.covariance * &scaled;
        let mut entries = Buffer::take(size * size);
        let weighed = scaled.transpose() * &product;
        for column in 0..size {
            let target = &mut entries[column * size..(column + 1) * size];
            target.iter_mut().zip(weighed.col(column).iter()).for_each(|(t, w)| *t = *w);
            target[column] += 1.0;
        }
        let factor = Factor::new(entries, size, Par::Seq)?;
        let solve = |mut right: Mat<f64>| {
            solve_lower_triangular_in_place(factor.view(), right.as_mut(), Par::Seq);
            right
        };
        let whitening = solve(scaled.transpose().to_owned());
        let whitened = solve(product.transpose().to_owned());
        factor.forward(&mut misfit);
        let weights = times(whitening.transpose(), &misfit);
        let shift = times(prior.covariance.as_ref(), &weights);
        let log_determinant: f64 = (0..size).map(|k| 2.0 * factor.column(k)[0].ln()).sum();
        let trace: f64 =
            (0..size).map(|k| dot(whitening.col(k).iter(), whitened.col(k).iter())).sum();
        let divergence = 0.5 * (log_determinant - trace + dot(weights.iter(), shift.iter()));
        let mean = prior.mean.iter().zip(&shift).map(|(m, s)| m + s).collect();
        let approximation = Self { mean, weights, whitening, whitened, divergence };
        approximation.divergence.is_finite().then_some(approximation)
    }

    /// S of some rows.
    pub fn covariance(&self, prior: &Normal, rows: &[usize]) -> Mat<f64> {
        Mat::from_fn(rows.len(), rows.len(), |i, j| {
            let known = dot(self.whitened.col(rows[i]).iter(), self.whitened.col(rows[j]).iter());
            prior.covariance[(rows[i], rows[j])] - known
        })
    }

    /// Variance of one row.
    pub fn variance(&self, prior: &Normal, row: usize) -> f64 {
        let known = dot(self.whitened.col(row).iter(), self.whitened.col(row).iter());
        (prior.covariance[(row, row)] - known).max(0.0)
    }

    /// Of (objective − divergence), whose derivatives in q at each site, the divergence included,
    /// are `pulls`; sites without one have none.
    ///
    /// With P = TᵀT, C = I − PK, the pulls ā and S̄ put together, and the sites' own normaliser:
    /// ∂/∂m = w + C ā and ∂/∂K = ½(wwᵀ − P) + ½(C ā wᵀ + w (C ā)ᵀ) + C S̄ Cᵀ.
    pub fn pull_back(&self, prior: &Normal, sites: &[Site], pulls: &[Option<Pull>]) -> Slopes {
        let size = self.mean.len();
        let mut of_mean = vec![0.0; size];
        let mut of_covariance = Mat::<f64>::zeros(size, size);
        for (site, pull) in sites.iter().zip(pulls) {
            let Some(pull) = pull else { continue };
            for (i, row) in site.rows.iter().enumerate() {
                of_mean[*row] = pull.mean[i];
                for (j, column) in site.rows.iter().enumerate() {
                    of_covariance[(*row, *column)] = pull.covariance[(i, j)];
                }
            }
        }
        let passed = Mat::<f64>::identity(size, size) - self.whitening.transpose() * &self.whitened;
        let moved = times(passed.as_ref(), &of_mean);
        let mut covariance = &passed * &of_covariance * passed.transpose();
        let precision = self.whitening.transpose() * &self.whitening;
        for column in 0..size {
            for row in 0..size {
                let (a, b) = (self.weights[row], self.weights[column]);
                covariance[(row, column)] +=
                    0.5 * (a * b - precision[(row, column)] + moved[row] * b + a * moved[column]);
            }
        }
        // S = CᵀK
        let spread = &prior.covariance - self.whitened.transpose() * &self.whitened;
        let along = times(spread.as_ref(), &of_mean);
        let both = &spread * &of_covariance * &spread;
        let sigma = sites.iter().map(|site| self.of_sigma(site, &along, &both)).collect();
        let mean = self.weights.iter().zip(&moved).map(|(w, c)| w + c).collect();
        Slopes { mean, covariance, sigma }
    }

    /// 2 tr(S S̄ S Λ) − 2 āᵀ S w over the rows of a site, since w = λ − Λa there.
    fn of_sigma(&self, site: &Site, along: &[f64], both: &Mat<f64>) -> f64 {
        let precision = site.precision();
        let scale = site.sigma.powi(-2);
        let mut slope = 0.0;
        for (i, row) in site.rows.iter().enumerate() {
            slope -= 2.0 * along[*row] * self.weights[*row];
            for (j, column) in site.rows.iter().enumerate() {
                slope += 2.0 * scale * both[(*row, *column)] * precision[(j, i)];
            }
        }
        slope
    }
}

fn dot<'a>(a: impl Iterator<Item = &'a f64>, b: impl Iterator<Item = &'a f64>) -> f64 {
    a.zip(b).map(|(a, b)| a * b).sum()
}

fn times(matrix: MatRef<'_, f64>, x: &[f64]) -> Vec<f64> {
    (matrix * ColRef::from_slice(x)).iter().copied().collect()
}
