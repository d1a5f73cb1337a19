//! Neural networks with the boundary conditions built in (HCNN).
//!
//! u = m + Σ φₚ zₚ with the mean and features of a constrained prior, and for each zₚ a network of
//! one hidden layer of tanh units in place of a Gaussian process (4.28): of the axes that zₚ depends
//! on, or for traces on the edges of a polygon of the position along the edge. All derivatives, in
//! the coordinates and in the weights, are in closed form.

mod layout;

use crate::coefficients::PointCoefficients;
use crate::data::{Data, Group, check, check_places};
use crate::error::GpError;
use crate::operator::Operator;
use crate::optimise::minimise;
use crate::prior::Prior;
use crate::state::combine;
use layout::Layout;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// How a network is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkOptions {
    /// Hidden units of each latent function.
    pub width: usize,
    /// Random starts; one at least is tried.
    pub restarts: usize,
    /// Iterations of each at most.
    pub iterations: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for NetworkOptions {
    fn default() -> Self {
        Self { width: 16, restarts: 4, iterations: 2000, seed: 0 }
    }
}

/// A trained network.
#[derive(Debug)]
pub struct Network<const D: usize> {
    prior: Prior<D>,
    layout: Layout,
    weights: Vec<f64>,
    /// Mean squared misfit, each group of observations counted as in (4.49); infinite before training.
    pub loss: f64,
    /// Evaluations of loss and gradient that the training took, over all restarts.
    pub evaluations: usize,
}

/// An operator compiled at points.
struct Leg<const D: usize> {
    points: PointCoefficients<D>,
    /// For each part, a_β.
    coefficients: Vec<Vec<f64>>,
}

/// One group of observations.
struct Target<const D: usize> {
    /// The operator at its points; for jumps also at the other end, with the opposite sign.
    legs: Vec<Leg<D>>,
    /// y − mean.
    residual: Vec<f64>,
}

impl<const D: usize> Leg<D> {
    fn new(
        prior: &Prior<D>,
        operator: &Operator<D>,
        places: (&[[f64; D]], &str),
        factor: f64,
    ) -> Result<Self, GpError> {
        let mut parameters = Vec::new();
        let points = PointCoefficients::new(prior, operator, places, &mut parameters)?;
        if let Some(free) = parameters.first() {
            return Err(GpError::Problem(format!(
                "parameter {} is free; networks are trained on equations with known coefficients",
                free.name()
            )));
        }
        let points = points.scaled(factor);
        let factors = points.factors(&[]);
        let coefficients =
            points.parts.iter().map(|part| combine(1.0, &factors, &part.arrays)).collect();
        Ok(Self { points, coefficients })
    }
}

impl<const D: usize> Target<D> {
    fn new(prior: &Prior<D>, group: &Group<D>, number: usize) -> Result<Self, GpError> {
        let operator = group.operator.as_ref().unwrap_or(&prior.equation);
        let whose = format!("observation group {}", number + 1);
        let mut legs = vec![Leg::new(prior, operator, (&group.points, &whose), 1.0)?];
        for (factor, points) in &group.further {
            legs.push(Leg::new(prior, operator, (points, &whose), *factor)?);
        }
        let mut residual = group.values.clone();
        for Leg { points, .. } in &legs {
            points.add_mean(&points.factors(&[]), -1.0, &mut residual);
        }
        Ok(Self { legs, residual })
    }

    /// L u − L m at one point, its gradient in the weights added to `gradient`.
    fn evaluate(
        &self,
        layout: &Layout,
        point: usize,
        weights: &[f64],
        mut gradient: Option<&mut [f64]>,
    ) -> f64 {
        let mut sum = 0.0;
        let mut terms = Vec::new();
        for leg in &self.legs {
            let mut offset = 0;
            for (part, compiled) in leg.points.parts.iter().enumerate() {
                let x = std::array::from_fn(|d| compiled.axes[d][point]);
                let range = offset..offset + layout.size_of(part);
                offset = range.end;
                terms.clear();
                let orders = compiled.orders.iter().enumerate();
                terms.extend(orders.map(|(number, orders)| {
                    (*orders, leg.coefficients[part][number * leg.points.count + point])
                }));
                let own = gradient.as_deref_mut().map(|gradient| &mut gradient[range.clone()]);
                sum += layout.add(part, &weights[range], x, &terms, own);
            }
        }
        sum
    }
}

/// The loss (4.49), and its gradient in the weights.
fn loss<const D: usize>(
    targets: &[Target<D>],
    layout: &Layout,
    weights: &[f64],
) -> (f64, Vec<f64>) {
    let mut loss = 0.0;
    let mut gradient = vec![0.0; weights.len()];
    let mut own = vec![0.0; weights.len()];
    for target in targets {
        let count = target.residual.len().max(1) as f64;
        for (point, y) in target.residual.iter().enumerate() {
            own.fill(0.0);
            let misfit = target.evaluate(layout, point, weights, Some(&mut own)) - y;
            loss += misfit * misfit / count;
            let factor = 2.0 * misfit / count;
            gradient.iter_mut().zip(&own).for_each(|(sum, slope)| *sum += factor * slope);
        }
    }
    (loss, gradient)
}

impl<const D: usize> Network<D> {
    /// Trains on data by least squares (4.47–4.49), with L-BFGS from random starts.
    ///
    /// The operators' parameters must be known: an equation with free ones is refused. Noise
    /// levels are not used. Pseudo-observations of a penalised prior count as observations.
    ///
    /// # Errors
    /// If the data are unusable (see [`crate::Model::new`]), the equation has free parameters, or
    /// no start leads anywhere.
    pub fn train(
        prior: Prior<D>,
        data: &Data<D>,
        options: &NetworkOptions,
    ) -> Result<Self, GpError> {
        let mut groups = data.placed()?.to_vec();
        groups.extend(prior.boundary.iter().cloned());
        check(&groups, &prior.domain)?;
        let layout = Layout::new(&prior, options.width);
        let numbered = groups.iter().enumerate();
        let targets = numbered
            .map(|(number, group)| Target::new(&prior, group, number))
            .collect::<Result<Vec<_>, _>>()?;
        let mut evaluations = 0;
        let mut random = ChaCha8Rng::seed_from_u64(options.seed);
        let bounds = vec![[-1e3, 1e3]; layout.size()];
        let best = (0..options.restarts.max(1))
            .filter_map(|_| {
                let start = layout.random(&mut random);
                let objective = |weights: &[f64]| {
                    evaluations += 1;
                    Some(loss(&targets, &layout, weights))
                };
                minimise(objective, &start, &bounds, options.iterations, |_, _| ())
            })
            .min_by(|a, b| a.value.total_cmp(&b.value));
        let best = best.ok_or_else(|| {
            GpError::Data("the loss is not finite at any start; rescale the data".into())
        })?;
        Ok(Self { layout, weights: best.point, loss: best.value, evaluations, prior })
    }

    /// A network that was not trained: weights drawn from normal distributions of variance one,
    /// 1/`width` for the output weights, in coordinates that run from −1 to 1 over the domain (4.30).
    ///
    /// As the width grows, u tends to the Gaussian process with the prior's mean and features and
    /// the kernel 1 + E tanh(b + w·x) tanh(b + w·x′) (Theorem 4.6.2).
    pub fn random(prior: Prior<D>, width: usize, seed: u64) -> Self {
        let layout = Layout::new(&prior, width);
        let weights = layout.random(&mut ChaCha8Rng::seed_from_u64(seed));
        Self { layout, weights, loss: f64::INFINITY, evaluations: 0, prior }
    }

    /// u at points.
    ///
    /// # Errors
    /// If a point is not finite, or a feature has no finite value there.
    pub fn mean(&self, points: &[[f64; D]]) -> Result<Vec<f64>, GpError> {
        self.mean_of(&Operator::identity(), points)
    }

    /// An operator without parameters applied to u.
    ///
    /// # Errors
    /// As [`Network::mean`], and if the operator has parameters or takes more derivatives than
    /// are supported.
    pub fn mean_of(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Vec<f64>, GpError> {
        check_places(points)?;
        let leg = Leg::new(&self.prior, operator, (points, "the prediction"), 1.0)?;
        let mut mean = vec![0.0; points.len()];
        leg.points.add_mean(&leg.points.factors(&[]), 1.0, &mut mean);
        let target = Target { legs: vec![leg], residual: Vec::new() };
        for (point, mean) in mean.iter_mut().enumerate() {
            *mean += target.evaluate(&self.layout, point, &self.weights, None);
        }
        Ok(mean)
    }
}
