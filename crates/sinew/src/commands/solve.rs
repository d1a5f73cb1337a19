//! Equilibria.

use super::{CaseArguments, ThetaArguments, Usage, solved};
use anyhow::Result;
use clap::Args;
use sinew::output::{Fields, displacement_in_words};
use sinew::theta_in_words;
use sinew_report::format::trimmed;

/// Which equilibria.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes cases.csv, cases.npz, NNNN.vtu and cases.pvd for ParaView into OUT/solve. Parameters outside their ranges are
solved with a warning.

Example: sinew solve IdealVentricle --theta a=0.18,b=2.6,a_f=3.3,b_f=2.7,p=8mmHg")]
pub(crate) struct Solve {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    /// Most cases to write for ParaView
    #[arg(long, value_name = "COUNT", default_value_t = 20)]
    pictures: usize,
}

impl Solve {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, body, folder) = self.case.open()?;
        let thetas = self.theta.read(&body)?;
        for theta in &thetas {
            body.check_theta(theta)
                .map_err(|error| Usage(format!("{}: {error}", theta_in_words(&body, theta))))?;
        }
        let found = solved(&body, &thetas, "solve", None)?;
        let unit = &body.units.length;
        for (theta, field) in found.thetas.iter().zip(&found.fields) {
            let volumes = body.cavities.iter().zip(body.cavity_volumes(field));
            let volumes: String = volumes
                .map(|(cavity, v)| format!(", volume of {} {} {unit}3", cavity.name, trimmed(v, 6)))
                .collect();
            println!(
                "{}: displacement {}{volumes}",
                theta_in_words(&body, theta),
                displacement_in_words(field, unit)
            );
        }
        let folder = folder.join("solve");
        if !found.fields.is_empty() {
            let (thetas, found) = (&found.thetas[..], vec![("solved", found.fields)]);
            Fields { body: &body, thetas, found }.write(&folder, self.pictures)?;
            println!("written: {}", folder.display());
        }
        match found.failures.len() {
            0 => Ok(()),
            failed => anyhow::bail!("{failed} of {} cases have no equilibrium", thetas.len()),
        }
    }
}
