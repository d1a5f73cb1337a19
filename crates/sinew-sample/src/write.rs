//! Draws as files for other programs.

use crate::error::SampleError;
use serde::{Serialize, Serializer};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Groups of draws that `arviz` opens, one number by chain and draw under each name, with the labels of the data in `coords` and
/// `dims`. Every draw has the same weight, since `arviz` reads no others.
///
/// ```python
/// groups = json.load(open("posterior.json"))
/// data = arviz.from_dict(**groups)  # versions 0.x
/// labels = {key: groups.pop(key, None) for key in ("coords", "dims")}  # versions 1.x, which read no lists
/// data = arviz.from_dict({g: {n: numpy.array(x) for n, x in v.items()} for g, v in groups.items()}, **labels)
/// arviz.loo(data)
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ArvizDict(BTreeMap<String, Group>);

/// Quantities in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq)]
struct Group(Vec<(String, Value)>);

impl Serialize for Group {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, values)| (name, values)))
    }
}

impl ArvizDict {
    /// Adds a quantity by chain and draw to a group such as `posterior`, `prior` or `posterior_predictive`.
    pub fn with(mut self, group: &str, name: &str, chains: Vec<Vec<f64>>) -> Self {
        self.put(group, name, chains.into());
        self
    }

    /// Adds an observed value.
    pub fn with_observed(mut self, name: &str, value: f64) -> Self {
        self.put("observed_data", name, value.into());
        self
    }

    /// Adds the logarithm of the likelihood by chain, draw and datum, and the labels of the data.
    pub fn with_log_likelihood(mut self, labels: Vec<String>, values: Vec<Vec<Vec<f64>>>) -> Self {
        self.put("log_likelihood", "data", values.into());
        self.put("coords", "datum", labels.into());
        self.put("dims", "data", vec!["datum"].into());
        self
    }

    fn put(&mut self, group: &str, name: &str, values: Value) {
        let Group(all) = self.0.entry(group.into()).or_default();
        all.retain(|(own, _)| own != name);
        all.push((name.into(), values));
    }

    /// The text of the file; numbers that are not finite become `null`.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Writes the file.
    ///
    /// # Errors
    /// A file that cannot be written, with its path.
    pub fn write(&self, path: &Path) -> Result<(), SampleError> {
        put(path, self.to_json())
    }
}

/// Writes a table of draws: chain and draw from 0, then the columns, each by chain and draw.
///
/// # Errors
/// Columns that differ in their draws, a file that cannot be written, with its path.
pub fn write_csv(path: &Path, columns: &[(String, Vec<Vec<f64>>)]) -> Result<(), SampleError> {
    let shape = |of: &[Vec<f64>]| of.iter().map(Vec::len).collect::<Vec<_>>();
    let first = columns.first().map(|(_, chains)| shape(chains)).unwrap_or_default();
    for (name, chains) in columns {
        if shape(chains) != first {
            let [found, expected]: [usize; 2] = [shape(chains), first].map(|s| s.iter().sum());
            return Err(SampleError(format!("draws of {name}: {found} where {expected} belong")));
        }
    }
    let mut text = String::from("chain,draw");
    for (name, _) in columns {
        text += &match name.contains([',', '"']) {
            true => format!(",\"{}\"", name.replace('"', "\"\"")),
            false => format!(",{name}"),
        };
    }
    text.push('\n');
    for (chain, &draws) in first.iter().enumerate() {
        for draw in 0..draws {
            let _ = write!(text, "{chain},{draw}");
            for (_, chains) in columns {
                let _ = write!(text, ",{}", chains[chain][draw]);
            }
            text.push('\n');
        }
    }
    put(path, text)
}

fn put(path: &Path, text: String) -> Result<(), SampleError> {
    std::fs::write(path, text).map_err(|why| SampleError(format!("{}: {why}", path.display())))
}
