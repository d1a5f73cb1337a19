//! The solution at the centre of the parameters' ranges, followed to second order, and a regression of what that leaves.

use crate::store::{read_json, write_json};
use crate::{Body, Design, Error, PodRegression, Result, coordinates, graph, parameters};
use sinew_coordinates::Motions;
use sinew_fem::{Options, Solver};
use sinew_graph::Topology;
use std::path::Path;

/// Displacements that follow the parameters from one solution: derivatives by the implicit function theorem, second order
/// with the stiffness of that solution, both in motions of the body's clusters, which turn where a displacement would stretch.
#[derive(Clone, Debug)]
pub(crate) struct Series(Motions);

/// Parameter sets that parts of the orders are tried at.
const TRIED: usize = 16;
const FILE: &str = "series.json";

impl Series {
    /// Solves once, at the centre of the parameters' ranges.
    pub(crate) fn of(body: &Body, seed: u64) -> Result<Self> {
        let mut solver = Solver::new(body)?;
        let solved = solver.solve(&body.centre(), &Options::default())?;
        Self::about_solved(&mut solver, &solved.displacement, seed)
    }

    /// About the solution at the centre of the parameters' ranges.
    pub(crate) fn about_solved(solver: &mut Solver<'_>, solved: &[f64], seed: u64) -> Result<Self> {
        let body = solver.body();
        let topology = graph::topology_of_met(body, seed)?;
        let tried = Design::LatinHypercube.sample(&body.parameters, TRIED, seed)?;
        Self::about(solver, &topology, solved, &tried)
    }

    /// About a state near to equilibrium at that centre; orders and form are chosen at the parameter sets `tried`.
    pub(crate) fn about(
        solver: &mut Solver<'_>,
        topology: &Topology,
        state: &[f64],
        tried: &[Vec<f64>],
    ) -> Result<Self> {
        let body = solver.body();
        let motions = Motions::about(state, topology, body, &body.centre())?;
        Ok(Self(coordinates::following(solver, motions, tried)?.0))
    }

    /// Displacement at θ, node by node \[length\].
    pub(crate) fn at(&self, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
        Ok(self.0.followed(&parameters::scaling(body)?.standardise(theta)?, body)?)
    }
}

/// What a series, a regression of simulations, or a regression of what a series leaves of them, predicts.
#[derive(Clone, Debug)]
pub(crate) struct Regressed {
    /// What the regression is about; its mean alone where there is none.
    pub series: Option<Series>,
    /// None where nothing but the series was asked for.
    pub regression: Option<PodRegression>,
}

impl Regressed {
    /// Displacement at θ, node by node \[length\].
    pub(crate) fn predict(&self, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
        let mut field = match &self.regression {
            Some(regression) => regression.predict(theta)?,
            None => vec![0.0; 3 * body.nodes],
        };
        if let Some(series) = &self.series {
            field
                .iter_mut()
                .zip(series.at(body, theta)?)
                .for_each(|(u, of_series)| *u += of_series);
        }
        Ok(field)
    }

    /// A regression of the fields, or of what a series leaves of them where that halves the error by leaving one simulation out; and
    /// that error, root mean square norm relative to that of the fields.
    pub(crate) fn fit(
        body: &Body,
        series: Option<&Series>,
        thetas: &[Vec<f64>],
        fields: &[Vec<f64>],
    ) -> Result<(Self, f64)> {
        let plain = PodRegression::fit(&body.parameters, thetas, fields)?;
        let error = plain.leave_one_out();
        let plain = (Self { series: None, regression: Some(plain) }, error);
        let Some(series) = series else { return Ok(plain) };
        let left = |(theta, field): (&Vec<f64>, &Vec<f64>)| -> Result<Vec<f64>> {
            let series = series.at(body, theta)?;
            Ok(field.iter().zip(series).map(|(u, of_series)| u - of_series).collect())
        };
        let left: Vec<Vec<f64>> = thetas.iter().zip(fields).map(left).collect::<Result<_>>()?;
        let regression = PodRegression::fit(&body.parameters, thetas, &left)?;
        let error = regression.leave_one_out() * norm(&left) / norm(fields).max(f64::MIN_POSITIVE);
        // A series takes longer to predict.
        if 2.0 * error >= plain.1 {
            return Ok(plain);
        }
        Ok((Self { series: Some(series.clone()), regression: Some(regression) }, error))
    }

    /// What it is, in words.
    pub(crate) fn detail(&self) -> String {
        let regression = self.regression.as_ref().map(|regression| {
            format!("{} modes, {}", regression.modes(), regression.interpolation())
        });
        match (&self.series, regression) {
            (None, Some(regression)) => regression,
            (_, None) => "second order about one solution".into(),
            (Some(_), Some(regression)) => {
                format!("{regression}, of what second order about one solution leaves")
            }
        }
    }

    /// Writes a folder that [`Regressed::load`] reads.
    pub(crate) fn save(&self, folder: &Path) -> Result<()> {
        if let Some(Series(motions)) = &self.series {
            write_json(&folder.join(FILE), motions)?;
        }
        self.regression.as_ref().map_or(Ok(()), |regression| regression.save(folder))
    }

    /// Reads a folder that [`Regressed::save`] wrote.
    pub(crate) fn load(folder: &Path, body: &Body) -> Result<Self> {
        let series = read_json::<Motions>(&folder.join(FILE))?.map(Series);
        let regression = match PodRegression::load(folder, &body.parameters) {
            Err(Error::NoEmulator { .. }) if series.is_some() => None,
            found => Some(found?),
        };
        Ok(Self { series, regression })
    }
}

fn norm(fields: &[Vec<f64>]) -> f64 {
    fields.iter().flatten().map(|u| u * u).sum::<f64>().sqrt()
}
