//! Posteriors by emulators of stored runs: coverage, modes, and errors of the emulator.

use crate::program::{done, refused};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew::emulate::{Observer, Output, Progress, RunsEmulator, share_of};
use sinew::runs::{Measured, RunsPosterior};
use sinew::{Design, Parameter};
use sinew_sample::{NutsOptions, standard_normals};
use std::fmt::Write;
use std::ops::ControlFlow;

/// Emulator of two numbers of a stiffness and an angle, of this many runs.
pub(crate) fn two_numbers(count: usize) -> (RunsEmulator, Vec<Vec<f64>>) {
    let parameters = vec![
        Parameter::log("k", "kPa", 1.0..=10.0),
        Parameter::linear("angle", "deg", -60.0..=60.0),
    ];
    let thetas = Design::Sobol.sample(&parameters, count, 5).unwrap();
    let outputs = [("volume", "ml"), ("strain", "1")].into_iter().enumerate();
    let outputs: Vec<Output> = outputs
        .map(|(place, (name, unit))| Output {
            name: name.into(),
            unit: unit.into(),
            values: thetas.iter().map(|theta| vec![truth(theta)[place]]).collect(),
        })
        .collect();
    let unseen = Design::LatinHypercube.sample(&parameters, 100, 6).unwrap();
    (RunsEmulator::fit(parameters, &thetas, &outputs, None, &mut ()).unwrap(), unseen)
}

fn truth(theta: &[f64]) -> [f64; 2] {
    let (k, angle) = (theta[0], theta[1].to_radians());
    [
        60.0 + 50.0 / k * (1.0 + 0.3 * angle.sin()),
        0.1 * angle + 0.05 * (2.0 * angle).sin() + 0.05 / k,
    ]
}

/// Shares of the 95 % intervals that hold the parameters which made the data, with noise of these standard deviations, and the share of
/// posteriors that were refused.
fn coverage(runs: usize, sd: [f64; 2]) -> ([f64; 2], f64) {
    let (emulator, unseen) = two_numbers(runs);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut held, mut answered) = ([0; 2], 0);
    for theta in &unseen {
        let noise = standard_normals(2, &mut random);
        let data: Vec<Measured> = ["volume", "strain"]
            .into_iter()
            .enumerate()
            .map(|(at, output)| {
                let value = truth(theta)[at] + sd[at] * noise[at];
                Measured { output: output.into(), value, sd: sd[at] }
            })
            .collect();
        let options = NutsOptions { warmup: 150, draws: 150, ..NutsOptions::default() };
        let found = RunsPosterior::new(&emulator, &data, &options, &mut ());
        let Ok(posterior) = found else { continue };
        answered += 1;
        for (at, held) in held.iter_mut().enumerate() {
            let [low, _, high] = posterior.draws.summary(at).quantiles;
            *held += usize::from((low..=high).contains(&theta[at]));
        }
    }
    let refused = 1.0 - answered as f64 / unseen.len() as f64;
    (held.map(|held| held as f64 / answered as f64), refused)
}

#[test]
fn intervals_of_posteriors_hold_the_parameters_that_made_the_data() {
    // The error of the emulator of 20 runs exceeds the second noise.
    for (runs, sd) in [(40, [1.0, 0.01]), (20, [0.2, 1e-3])] {
        let (shares, refused) = coverage(runs, sd);
        println!("{runs} runs, noise {sd:?}: {shares:?}, refused {refused}");
        // Where two sets of parameters are likely.
        assert!(refused <= 0.05, "{runs}: {refused}");
        // 0.95 of 100, within the 0.5 and 99.5 % quantiles of a binomial distribution.
        assert!(shares.iter().all(|share| (0.89..=0.99).contains(share)), "{runs}: {shares:?}");
    }
}

#[test]
fn slopes_of_emulated_numbers_are_those_of_differences() {
    let (emulator, _) = two_numbers(12);
    let (shares, step) = ([0.3, 0.62], 1e-4);
    for (place, at) in emulator.at_shares(&shares, &[0, 1]).iter().enumerate() {
        for d in 0..2 {
            let moved = |step: f64| {
                let mut shares = shares;
                shares[d] += step;
                emulator.at_shares(&shares, &[place]).remove(0)
            };
            let (more, less) = (moved(step), moved(-step));
            let value = (more.value - less.value) / (2.0 * step);
            let deviation = (more.deviation - less.deviation) / (2.0 * step);
            // Truncation h²; the variance is a small difference of numbers of order one.
            assert!((value - at.value_slopes[d]).abs() < 1e-7 * at.value.abs().max(1.0));
            let error = (deviation - at.deviation_slopes[d]).abs();
            assert!(error < 1e-5 * deviation.abs().max(at.deviation), "{error:e}");
        }
    }
}

#[test]
fn draws_are_weighted_by_what_the_error_of_the_emulator_changes() {
    let parameter = Parameter::linear("a", "1", 0.0..=2.0);
    let thetas = Design::LatinHypercube.sample(std::slice::from_ref(&parameter), 12, 4).unwrap();
    let values = thetas.iter().map(|t| vec![t[0] + 0.1 * (9.0 * t[0]).sin()]).collect();
    let output = Output { name: "v".into(), unit: "1".into(), values };
    let emulator = RunsEmulator::fit(vec![parameter], &thetas, &[output], None, &mut ()).unwrap();
    let (value, sd) = (0.9 + 0.1 * 8.1f64.sin(), 1e-4);
    let data = [Measured { output: "v".into(), value, sd }];
    let options = NutsOptions { warmup: 150, draws: 150, ..NutsOptions::default() };
    let posterior = RunsPosterior::new(&emulator, &data, &options, &mut ()).unwrap();
    let told = posterior.in_words();
    assert!(told.iter().any(|line| line.contains("Pareto k̂")), "{told:?}");
    let groups: serde_json::Value = serde_json::from_str(&posterior.to_arviz().to_json()).unwrap();
    let weights = &groups["sample_stats"]["log_weight_without_emulator_error"];
    let weights = weights.as_array().unwrap().iter().flat_map(|chain| chain.as_array().unwrap());
    let constants: Vec<f64> = weights
        .zip(posterior.draws.pooled())
        .map(|(weight, theta)| {
            let pairs = emulator.parameters.iter().zip(theta);
            let shares: Vec<f64> = pairs.map(|(p, x)| share_of(p, *x)).collect();
            let found = emulator.at_shares(&shares, &[0]).remove(0);
            let normal =
                |variance: f64| -0.5 * ((value - found.value).powi(2) / variance + variance.ln());
            weight.as_f64().unwrap() - normal(sd * sd) + normal(sd * sd + found.deviation.powi(2))
        })
        .collect();
    // θ is that of the shares but for rounding.
    let apart = constants.iter().map(|c| (c - constants[0]).abs()).fold(0.0, f64::max);
    assert!(constants.len() == 600 && apart < 1e-6, "{apart:e}");
}

#[test]
fn measured_values_of_outputs_give_a_posterior_without_a_solver() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut table = String::from("k [kPa],angle [deg],volume [ml],strain\n");
    let (_, thetas) = two_numbers(12);
    for theta in thetas.iter().take(40) {
        let [volume, strain] = truth(theta);
        writeln!(table, "{},{},{volume},{strain}", theta[0], theta[1]).unwrap();
    }
    std::fs::write(folder.join("runs.csv"), table).unwrap();
    done(folder, "train --from-table runs.csv --parameters k,angle");
    let data = |text: &str| {
        let text = format!("emulator = \"out/runs\"\n{text}");
        std::fs::write(folder.join("patient.toml"), text).unwrap();
    };
    let [volume, strain] = truth(&[3.0, -20.0]);
    data(&format!(
        "[[data]]\noutput = \"volume\"\nvalue = {volume}\nsd = 0.5\n[[data]]\noutput = \"strain\"\nvalue = {strain}\nsd = 0.005\n"
    ));
    let told = done(folder, "calibrate patient.toml");
    assert!(told.contains("k [kPa]: 3.0") && told.contains("identified by the data"), "{told}");
    assert!(told.contains("no solver has confirmed it"), "{told}");
    // Its error is below the noise.
    assert!(!told.contains("k̂"), "{told}");
    let out = folder.join("out/patient/calibrate");
    let draws = std::fs::read_to_string(out.join("posterior.csv")).unwrap();
    assert!(draws.starts_with("chain,draw,k [kPa],angle [deg]\n"), "{draws:.60}");
    assert_eq!(draws.lines().count(), 4001);
    let groups = std::fs::read_to_string(out.join("posterior.json")).unwrap();
    assert!(groups.contains("\"observed_data\":{\"volume [ml]\""), "{groups:.200}");
    assert!(groups.contains("\"sample_stats\":{\"log_weight_without_emulator_error\":[["));
    let timeless = |told: &str| -> Vec<String> {
        told.lines().filter(|line| !line.contains(" done in ")).map(Into::into).collect()
    };
    assert_eq!(timeless(&done(folder, "calibrate patient.toml")), timeless(&told));

    let twice = "[[data]]\noutput = \"volume\"\nvalue = 70\nsd = 1\n";
    let refusals: [(&str, &str); 8] = [
        ("[[data]]\noutput = \"volum\"\nvalue = 70\nsd = 1\n", "did you mean `volume`"),
        ("[[data]]\noutput = \"volume\"\nvalue = 700\nsd = 1\n", "standard deviations from"),
        ("[[data]]\noutput = \"volume\"\nvalue = 70\nsd = 0\n", "positive sd"),
        ("[[data]]\noutput = \"volume\"\nvalue = 70\n", "line 2, data.0: `sd` is missing"),
        ("[[data]]\noutput = \"volume\"\nvalue = \"70 ml\"\nsd = 1\n", "data.0.value: the text"),
        ("", "there are no data"),
        ("draws = 12\n[[data]]\noutput = \"volume\"\nvalue = 70\nsd = 1\n", "draws a chain"),
        (&format!("{twice}{twice}"), "is there twice"),
    ];
    for (text, reason) in refusals {
        data(text);
        let (code, told) = refused(folder, "calibrate patient.toml");
        assert!(code == 2 && told.contains(reason), "{told}");
    }
    // Nothing of an earlier run stays beside an error; beyond all runs there is a warning.
    assert!(!out.join("posterior.csv").exists());
    data("[[data]]\noutput = \"volume\"\nvalue = 128\nsd = 3\n");
    let told = done(folder, "calibrate patient.toml");
    assert!(told.contains("k is most likely at an end of its range"), "{told}");
    let (code, told) = refused(folder, "calibrate patient.toml --resume");
    assert!(code == 2 && told.contains("leave them out"), "{told}");
}

#[test]
fn every_seed_finds_both_modes_and_refuses_to_choose() {
    let parameters = ["a", "b"].map(|name| Parameter::linear(name, "1", 0.0..=1.0)).to_vec();
    let thetas = Design::Sobol.sample(&parameters, 60, 5).unwrap();
    let column = |name: &str, of: fn(&[f64]) -> f64| Output {
        name: name.into(),
        unit: "1".into(),
        values: thetas.iter().map(|theta| vec![of(theta)]).collect(),
    };
    // Rises slowly and falls fast: of the mass above a = 0.5 there is a fifth.
    let outputs = [
        column("y", |t| (2.2 * std::f64::consts::PI * t[0].powi(3)).sin()),
        column("z", |t| t[1] + 0.05 * t[0]),
    ];
    let emulator = RunsEmulator::fit(parameters, &thetas, &outputs, None, &mut ()).unwrap();
    let data = [("y", 0.2, 0.02), ("z", 0.5, 0.1)].map(|(output, value, sd)| Measured {
        output: output.into(),
        value,
        sd,
    });
    for seed in 0..10 {
        let options = NutsOptions { warmup: 150, draws: 150, seed, ..NutsOptions::default() };
        let told = RunsPosterior::new(&emulator, &data, &options, &mut ()).map(|_| ());
        let told = told.expect_err("two modes").to_string();
        assert!(told.contains("add data that tell these apart"), "{seed}: {told}");
    }
}

#[test]
fn outputs_of_one_curve_share_the_error_of_the_emulator() {
    let parameter = Parameter::linear("a", "1", 0.0..=2.0);
    let curve = |a: f64| a + 0.1 * (9.0 * a).sin();
    let thetas = Design::LatinHypercube.sample(std::slice::from_ref(&parameter), 12, 4).unwrap();
    let output = |place: usize| Output {
        name: format!("v{place}"),
        unit: "1".into(),
        values: thetas.iter().map(|t| vec![(1.0 + 0.1 * place as f64) * curve(t[0])]).collect(),
    };
    let outputs: Vec<Output> = (0..20).map(output).collect();
    let emulator = RunsEmulator::fit(vec![parameter], &thetas, &outputs, None, &mut ()).unwrap();
    assert!((0..20).all(|place| emulator.correlation(0, place) > 0.9));
    let deviation = |count: usize| {
        let datum = |place: usize| {
            let factor = 1.0 + 0.1 * place as f64;
            Measured { output: format!("v{place}"), value: factor * curve(0.9), sd: 1e-4 * factor }
        };
        let data: Vec<_> = (0..count).map(datum).collect();
        let options = NutsOptions { warmup: 150, draws: 150, ..NutsOptions::default() };
        let found = RunsPosterior::new(&emulator, &data, &options, &mut ()).unwrap();
        found.draws.summary(0).deviation
    };
    // Were the errors independent, it would be √20 times smaller.
    let (one, all) = (deviation(1), deviation(20));
    assert!(all > 0.6 * one, "{all:e} by 20 outputs, {one:e} by one");
}

/// Chains would follow the surface of the emulator's error for minutes, and disagree.
#[test]
fn a_standard_deviation_far_below_the_error_of_the_emulator_is_refused_at_once() {
    let (emulator, _) = two_numbers(16);
    let datum = |sd| Measured { output: "volume".into(), value: 75.0, sd };
    struct Never;
    impl Observer for Never {
        fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
            panic!("{}", progress.stage)
        }
    }
    let told = RunsPosterior::new(&emulator, &[datum(1e-12)], &NutsOptions::default(), &mut Never);
    let told = told.expect_err("no measurement").to_string();
    assert!(told.contains("volume: an sd of 1e-12"), "{told}");
}
