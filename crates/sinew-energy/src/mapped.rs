//! Parameters of a law that are read from fewer entries of θ, or times a factor.

use smallvec::SmallVec;

/// Parameters of one point; on the stack for up to sixteen.
pub(crate) type Parameters = SmallVec<[f64; 16]>;

/// Known values of some of a law's parameters, and factors of some at each point.
#[derive(Clone, Debug)]
pub(crate) struct ParameterMap {
    /// Names of the parameters that θ lists, and their places among all.
    pub names: Vec<&'static str>,
    pub places: Vec<usize>,
    /// Values of all parameters; those that θ lists are filled in.
    values: Parameters,
    /// Places of parameters, and their factors point by point.
    pub scaled: Vec<(usize, Vec<f64>)>,
}

impl ParameterMap {
    /// Every parameter as θ lists it.
    pub(crate) fn of(names: &[&'static str]) -> Self {
        Self {
            names: names.to_vec(),
            places: (0..names.len()).collect(),
            values: SmallVec::from_elem(0.0, names.len()),
            scaled: Vec::new(),
        }
    }

    /// Known values of some of the parameters that are listed.
    pub(crate) fn known(mut self, held: &[Option<f64>]) -> Self {
        for (&place, value) in self.places.iter().zip(held) {
            self.values[place] = value.unwrap_or_default();
        }
        let free = (0..held.len()).filter(|&index| held[index].is_none());
        let (names, places) = free.map(|index| (self.names[index], self.places[index])).unzip();
        Self { names, places, ..self }
    }

    /// Entries of all parameters at a point: those of θ among others.
    fn among(&self, mut all: Parameters, point: usize, listed: &[f64]) -> Parameters {
        self.places.iter().zip(listed).for_each(|(&place, &value)| all[place] = value);
        for (place, factors) in &self.scaled {
            all[*place] *= factors[point];
        }
        all
    }

    /// Parameters of the law at a point.
    pub(crate) fn at(&self, point: usize, listed: &[f64]) -> Parameters {
        self.among(self.values.clone(), point, listed)
    }

    /// Rates of the law's parameters at a point.
    pub(crate) fn rates(&self, point: usize, listed: &[f64]) -> Parameters {
        self.among(SmallVec::from_elem(0.0, self.values.len()), point, listed)
    }
}
