//! Priors, the order of data, and solves that are kept in a file.

use sinew_calibrate::{
    Answer, Datum, Forward, ForwardError, Observed, Prior, Problem, Solves, Unknown,
};
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn coordinates_and_values_are_inverse_and_slopes_are_those_of_differences() {
    let priors = [
        Prior::LogUniform { range: [0.1, 10.0] },
        Prior::LogNormal { median: 2.0, deviation: 0.3 },
    ];
    for prior in priors {
        for y in [-2.5, -0.4, 0.0, 1.7] {
            let [logarithm, slope] = prior.logarithm(y);
            assert!((prior.coordinate(logarithm.exp()) - y).abs() < 1e-9);
            // Truncation of a central difference: h² times a third derivative of order one.
            let step = 1e-5;
            let difference = prior.logarithm(y + step)[0] - prior.logarithm(y - step)[0];
            assert!((difference / (2.0 * step) - slope).abs() < 1e-8);
        }
    }
}

#[test]
fn segments_are_sorted_by_their_numbers() {
    let names = ["strain 10 at late", "strain 2 at late", "strain 2 at early", "volume"];
    let data = names.map(|name| Datum::new(name, "strain", 0, 0.1, 0.02)).to_vec();
    let unknown = Unknown::new("k", "kPa", Prior::LogUniform { range: [0.1, 10.0] });
    let problem = Problem::new(vec![unknown], data, Vec::new()).unwrap();
    let sorted: Vec<&str> = problem.data.iter().map(|datum| datum.name.as_str()).collect();
    assert_eq!(sorted, ["strain 2 at early", "strain 2 at late", "strain 10 at late", "volume"]);
}

/// A model whose values have no short decimals; it counts its solves, and has no answer where the first parameter is 2.
#[derive(Default)]
struct Numbers {
    solves: AtomicUsize,
}

impl Forward for Numbers {
    fn parameters(&self) -> usize {
        2
    }

    fn observables(&self) -> usize {
        1
    }

    fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        if theta[0] == 2.0 {
            return Err(ForwardError { reason: "no body\nat rest".into() });
        }
        Ok(Observed { values: vec![1.0 / 3.0], jacobian: vec![vec![-2e17, f64::EPSILON]] })
    }
}

#[test]
fn solves_are_read_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solves.csv");
    let thetas = [vec![0.1 + 0.2, 1e-310], vec![2.0, 1.0], vec![1.0, 2.0]];
    // Answers, and the number of solves that were not in the file.
    let answers = |thetas: &[Vec<f64>]| -> (Vec<Answer>, usize) {
        let model = Numbers::default();
        let solves = Solves::new(&model).kept_in(&path, "numbers", true);
        let answers = solves.unwrap().at("test", thetas, true).unwrap();
        (answers, model.solves.load(Ordering::Relaxed))
    };
    assert_eq!(answers(&thetas[..2]).1, 2);
    let (found, new) = answers(&thetas[..2]);
    assert_eq!(new, 0);
    let observed = found[0].as_ref().unwrap();
    assert_eq!(observed.values, [1.0 / 3.0]);
    assert_eq!(observed.jacobian, [[-2e17, f64::EPSILON]]);
    assert_eq!(found[1].as_ref().unwrap_err().reason, "no body at rest");
    // A line without a checksum is no answer, and neither is one in which a digit was changed.
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{text}1e0,2e0,;3e0\n")).unwrap();
    assert_eq!(answers(&thetas).1, 1);
    let changed = text.replacen("3.3", "3.4", 1);
    assert_ne!(changed, text);
    std::fs::write(&path, changed).unwrap();
    assert_eq!(answers(&thetas[..2]).1, 1);
}
