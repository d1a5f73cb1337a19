//! Predictions and their corrections.

use super::{CaseArguments, MOST_WARNINGS, ThetaArguments, refuse, trained};
use anyhow::Result;
use clap::Args;
use sinew::output::{Fields, displacement_in_words};
use sinew::{Body, Case, Emulator, theta_in_words};
use std::path::{Path, PathBuf};

/// What both commands read.
#[derive(Debug, Args)]
pub(crate) struct Asked {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    /// Name of the emulator's folder within OUT, such as `regression` [default: the only one, or that of the case's recipe]
    #[arg(long, value_name = "NAME")]
    emulator: Option<String>,
    /// Most cases to write for ParaView
    #[arg(long, value_name = "COUNT", default_value_t = 20)]
    pictures: usize,
}

/// For which parameters.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes cases.csv, cases.npz, NNNN.vtu and cases.pvd into OUT/predict. Each case comes with an estimate of its error, by
Newton steps that contract, or says why there is none; --quick leaves it out. --refine 4 comes nearer, a tenth to a thousandth
of the error, at a tenth of a Newton step or less each.

Example: sinew sample OnceClampedBeam && sinew predict OnceClampedBeam --theta out/OnceClampedBeam/sample/thetas.csv")]
pub(crate) struct Predict {
    #[command(flatten)]
    asked: Asked,
    /// Quasi-Newton steps with the stiffness at the centre of the ranges, one for all cases
    #[arg(long, value_name = "STEPS", default_value_t = 0)]
    refine: usize,
    /// Without error estimates
    #[arg(long)]
    quick: bool,
}

/// For which parameters, and how often.
#[derive(Debug, Args)]
#[command(after_help = "\
Each step of Newton's method about squares the error of a prediction that is within 2 % of the truth. From above 4 % it
may hurt: then a warning says so. Writes into OUT/correct.

Example: sinew correct OnceClampedBeam --theta mu=75,lambda=80 --steps 2")]
pub(crate) struct Correct {
    #[command(flatten)]
    asked: Asked,
    /// Newton steps
    #[arg(long, default_value_t = 1)]
    steps: usize,
}

impl Asked {
    fn emulator<'b>(&self, case: &Case, body: &'b Body, folder: &Path) -> Result<Emulator<'b>> {
        let found = trained(folder)?;
        let own = case.training.recipe();
        let wanted = match (&self.emulator, &found[..]) {
            (Some(wanted), _) => wanted,
            (None, [(only, _)]) => only,
            (None, _) => own.key(),
        };
        match found.iter().find(|(name, _)| name == wanted) {
            Some((_, folder)) => Ok(Emulator::load(folder, body)?),
            None => {
                let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
                refuse(format!("choose one with --emulator NAME: {}", names.join(", ")))
            }
        }
    }

    fn write(&self, fields: &Fields<'_>, folder: PathBuf) -> Result<()> {
        fields.write(&folder, self.pictures)?;
        println!("written: {}", folder.display());
        Ok(())
    }
}

impl Predict {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.asked.case.open()?;
        let thetas = self.asked.theta.read(&body)?;
        let emulator = self.asked.emulator(&case, &body, &folder)?;
        let prediction = emulator.refine(&thetas, self.refine)?;
        let unit = &body.units.length;
        for (index, theta) in thetas.iter().enumerate() {
            let moved = displacement_in_words(prediction.field(index), unit);
            print!("{}: displacement {moved}", theta_in_words(&body, theta));
            if self.quick {
                println!();
                continue;
            }
            match emulator.estimate(&prediction, index) {
                Ok(estimate) => println!("; {}", estimate.in_words(unit)),
                Err(error) => println!("; no error estimate: {error}"),
            }
        }
        let found = vec![("predicted", prediction.fields())];
        self.asked.write(&Fields { body: &body, thetas: &thetas, found }, folder.join("predict"))
    }
}

impl Correct {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.asked.case.open()?;
        let thetas = self.asked.theta.read(&body)?;
        let emulator = self.asked.emulator(&case, &body, &folder)?;
        let predicted = emulator.predict(&thetas)?.fields();
        let mut corrected = Vec::with_capacity(thetas.len());
        for theta in &thetas {
            let correction = emulator.correct(theta, self.steps)?;
            println!("{}", theta_in_words(&body, theta));
            for (index, step) in correction.steps.iter().enumerate() {
                println!(
                    "  step {}: residual {:.1e} to {:.1e} of the forces, energy norm of the step {:.1e}, {:.1} ms",
                    index + 1,
                    step.residual_before / step.force_scale,
                    step.residual_after / step.force_scale,
                    step.energy_norm,
                    1e3 * step.seconds
                );
            }
            for warning in correction.warnings.iter().take(MOST_WARNINGS) {
                eprintln!("warning: {warning}");
            }
            corrected.push(correction.displacement);
        }
        let found = vec![("corrected", corrected), ("predicted", predicted)];
        self.asked.write(&Fields { body: &body, thetas: &thetas, found }, folder.join("correct"))
    }
}
