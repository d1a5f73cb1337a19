//! Conditions on the edges of a polygon, one by one.
//!
//! Functions Pₑ that satisfy the condition of one edge each are blended to Σ Wₑ Pₑ with
//! Wₑ = Π_{j≠e} ωⱼ² / Σₖ Π_{j≠k} ωⱼ² (Rvachev, Sheiko, Shapiro & Tsukanov 2001, *Transfinite
//! interpolation over implicitly defined sets*): on edge e that has value and slope of Pₑ. Next to a
//! Neumann or Robin edge Pₑ is a free trace, a function of the position along the edge alone, whose
//! normal derivative vanishes exactly because the edge is straight. What remains, the bubble,
//! vanishes once on Dirichlet edges and twice on others.
//!
//! At a corner all Pₑ share value and gradient, so that their blend is once differentiable there: what
//! the two conditions leave free of these three numbers is a feature of its own.

use super::extension::{along_edge, extension};
use super::feature::Feature;
use super::imposed::{Imposed, along};
use super::meeting::{Corner, Jet};
use super::wedges::{Held, adapted, normalised, singular};
use crate::condition::Condition;
use crate::domain::Domain;
use crate::edge::Edge;
use crate::error::Result;
use crate::field::{Field, field};
use crate::operator::Operator;
use crate::polygon::{Polygon, products_of_others};
use crate::problem::Problem;
use crate::series::Series;
use std::sync::Arc;

/// An edge with its condition.
#[derive(Clone, Debug)]
struct Conditioned<const D: usize> {
    number: usize,
    edge: Edge,
    condition: Condition<D>,
    /// Whether start and end are corners to conditioned edges.
    joined: [bool; 2],
}

impl<const D: usize> Conditioned<D> {
    /// Shapes along the edge of value one and of slope one at an end, zero at the other.
    fn shapes(&self, s: &Series) -> [[Series; 2]; 2] {
        let (one, length) = (s.constant(1.0), self.edge.length);
        let rest = &one - s;
        match self.joined {
            [true, true] => {
                let late = s.squared() * (s * -2.0 + 3.0);
                let early = &one - &late;
                [[early, s * &rest.squared() * length], [late, s.squared() * &rest * -length]]
            }
            _ => [[one.clone(), s * length], [one, &rest * -length]],
        }
    }

    /// Pₑ for jets at its joined ends, with the condition's data or with zeros in their place.
    fn function(&self, x: &[Series; D], jets: &[Option<Jet>; 2], data: bool) -> Series {
        let (f, s) = (self.edge.height(&x[0], &x[1]), self.edge.fraction(&x[0], &x[1]));
        let shapes = self.shapes(&s);
        let (normal, none) = (self.edge.normal, Field::zero());
        if let Some((a, c)) = self.condition.spring() {
            let sum = self.trace(&shapes, jets, x) * (&f * a.at(x.clone()) + 1.0);
            return if data { sum - &f * c.at(x.clone()) } else { sum };
        }
        match &self.condition {
            Condition::Dirichlet(value) => {
                let value = if data { value } else { &none };
                let mut sum = value.at(x.clone());
                for (end, (jet, [at, _])) in jets.iter().zip(&shapes).enumerate() {
                    let Some([_, ux, uy]) = jet else { continue };
                    let known = along(value, &normal, 1, &self.end(end, x));
                    sum = sum + &f * at * (ux * normal[0] + uy * normal[1] - known);
                }
                sum
            }
            Condition::Cauchy { value, slope } if data => {
                let missing = slope.at(x.clone()) + along(value, &normal, 1, x);
                value.at(x.clone()) - f * missing
            }
            _ => x[0].constant(0.0),
        }
    }

    /// The trace with the values and slopes of the jets at the ends.
    fn trace(&self, shapes: &[[Series; 2]; 2], jets: &[Option<Jet>; 2], x: &[Series; D]) -> Series {
        let [tx, ty] = self.edge.tangent;
        jets.iter().zip(shapes).fold(x[0].constant(0.0), |sum, (jet, [value, slope])| match jet {
            Some([u, ux, uy]) => sum + value * u + slope * &(ux * tx + uy * ty),
            None => sum,
        })
    }

    /// Factor of a free trace, if the condition leaves one.
    fn free_trace(&self, x: &[Series; D]) -> Option<Series> {
        let (a, _) = self.condition.spring()?;
        let (f, s) = (self.edge.height(&x[0], &x[1]), self.edge.fraction(&x[0], &x[1]));
        let rest = s.constant(1.0) - &s;
        let start = f * a.at(x.clone()) + 1.0;
        let ends = [s, rest].into_iter().zip(self.joined);
        Some(ends.filter(|(_, joined)| *joined).fold(start, |p, (end, _)| p * end.squared()))
    }

    fn end(&self, end: usize, x: &[Series; D]) -> [Series; D] {
        let mut at = x.clone();
        for d in 0..2 {
            let corner = self.edge.start[d] + end as f64 * self.edge.length * self.edge.tangent[d];
            at[d] = x[d].constant(corner);
        }
        at
    }
}

/// The conditions on a polygon's edges.
#[derive(Debug)]
pub(super) struct Edges<const D: usize> {
    polygon: Polygon,
    edges: Vec<Conditioned<D>>,
    /// Equations of each corner of the polygon, if both edges have conditions.
    corners: Vec<Option<Corner<D>>>,
}

impl<const D: usize> Edges<D> {
    /// Conditions of a problem; none without a polygon, or where it has none.
    pub(super) fn of(problem: &Problem<D>) -> Option<Arc<Self>> {
        let polygon = problem.domain().cross_section()?.clone();
        let any = problem.edges.iter().any(Option::is_some);
        any.then(|| Arc::new(Self::new(polygon, &problem.edges)))
    }

    fn new(polygon: Polygon, conditions: &[Option<Condition<D>>]) -> Self {
        let count = conditions.len();
        let has = |edge: usize| conditions[edge % count].is_some();
        let edges = (0..count)
            .filter_map(|number| {
                let condition = conditions[number].clone()?;
                let joined = [has(number + count - 1), has(number + 1)];
                let edge = polygon.edges()[number].clone();
                Some(Conditioned { number, edge, condition, joined })
            })
            .collect();
        let corners = (0..count)
            .map(|number| {
                let meeting = [(number + count - 1) % count, number];
                let [first, second] = meeting.map(|own| Some((own, conditions[own].as_ref()?)));
                let imposed = [first?, second?].into_iter().flat_map(|(own, condition)| {
                    let edge = &polygon.edges()[own];
                    let all = Imposed::of(condition, edge.outwards());
                    all.into_iter().map(|imposed| (imposed, edge.tangent))
                });
                Some(Corner::new(polygon.corners()[number], polygon.size(), imposed))
            })
            .collect();
        Self { polygon, edges, corners }
    }

    /// The values on all edges, if that is what their conditions are.
    fn values(&self) -> Option<Vec<Field<D>>> {
        let value = |own: &Conditioned<D>| match &own.condition {
            Condition::Dirichlet(value) => Some(value.clone()),
            _ => None,
        };
        let values: Vec<_> = self.edges.iter().map(value).collect::<Option<_>>()?;
        (values.len() == self.corners.len()).then_some(values)
    }

    pub(super) fn check_corners(&self, domain: &Domain<D>) -> Result<()> {
        if self.one_function().is_some() {
            return Ok(());
        }
        self.corners.iter().flatten().try_for_each(|corner| corner.check(domain))
    }

    /// The function that is held on all edges, which needs no blending.
    fn one_function(&self) -> Option<Field<D>> {
        let mut values = self.values()?.into_iter();
        let first = values.next()?;
        values.all(|value| value.is(&first)).then_some(first)
    }

    /// A function that satisfies the conditions on the edges.
    pub(super) fn mean(self: &Arc<Self>) -> Field<D> {
        if let Some(value) = self.one_function() {
            return value;
        }
        let (near, rest) = self.near().unwrap_or_else(|| (Field::zero(), self.clone()));
        let rest = rest.blended();
        field(move |x: [Series; D]| near.at(x.clone()) + rest.at(x))
    }

    /// Whether values are those of one function, which the blend then is.
    fn is_one_function(&self, values: &[Field<D>]) -> bool {
        self.polygon.corners().iter().zip(self.polygon.corners().iter().skip(2)).all(|(a, b)| {
            let mut at = [0.0; D];
            // Off the edges, and off what is symmetric.
            (at[0], at[1]) = (0.63 * a[0] + 0.37 * b[0], 0.63 * a[1] + 0.37 * b[1]);
            let first = values[0].value(at);
            values.iter().all(|value| (value.value(at) - first).abs() <= 1e-12 * first.abs())
        })
    }

    /// A function near the values, and the blend of the rest.
    fn near(&self) -> Option<(Field<D>, Arc<Self>)> {
        // With slopes, or edges without conditions, such a function is little determined away from the others.
        let values = self.values().filter(|values| !self.is_one_function(values))?;
        let near = extension(&self.polygon, &values)?;
        let rest = values.into_iter().zip(self.polygon.edges()).map(|(value, edge)| {
            let near = near.clone();
            let rest = field(move |x: [Series; D]| value.at(x.clone()) - near.at(x));
            Some(Condition::Dirichlet(along_edge(edge, rest)))
        });
        let rest: Vec<_> = rest.collect();
        Some((near, Arc::new(Self::new(self.polygon.clone(), &rest))))
    }

    /// All Wₑ.
    fn weights(&self, x: &Series, y: &Series) -> Vec<Series> {
        let size = self.polygon.size();
        let square =
            |own: &Conditioned<D>| (self.polygon.edge_distance(own.number, x, y) / size).squared();
        let distances: Vec<Series> = self.edges.iter().map(square).collect();
        let others = products_of_others(&distances);
        let sum = others.iter().fold(x.constant(0.0), |sum, other| sum + other);
        if sum.value() == 0.0 {
            // At a corner any shares will do, but derivatives do not exist.
            let singular = distances.iter().fold(x.constant(1.0), |p, d| p * d).squared().sqrt();
            let count = self.edges.len() as f64;
            return distances.iter().map(|_| &singular + 1.0 / count).collect();
        }
        others.iter().map(|other| other / &sum).collect()
    }

    fn blended(self: Arc<Self>) -> Field<D> {
        field(move |x: [Series; D]| {
            let weights = self.weights(&x[0], &x[1]);
            let jets: Vec<Option<Jet>> =
                self.corners.iter().map(|corner| corner.as_ref().map(|c| c.jet(&x))).collect();
            self.edges.iter().zip(weights).fold(x[0].constant(0.0), |sum, (own, weight)| {
                let next = (own.number + 1) % jets.len();
                let ends = [jets[own.number].clone(), jets[next].clone()];
                sum + weight * own.function(&x, &ends, true)
            })
        })
    }

    /// Condition on each edge, where it is a value or a slope alone.
    fn held(&self) -> Vec<Option<Held>> {
        let mut held = vec![None; self.corners.len()];
        for own in &self.edges {
            held[own.number] = match own.condition {
                Condition::Dirichlet(_) => Some(Held::Value),
                Condition::Neumann(_) => Some(Held::Slope),
                _ => None,
            };
        }
        held
    }

    /// Features as far as the plane goes.
    pub(super) fn planes(self: &Arc<Self>, equation: &Operator<D>) -> Vec<Feature<D>> {
        let smooth = self.values().and_then(|_| adapted(&self.polygon, equation));
        let mut planes: Vec<Feature<D>> = match smooth {
            Some(factors) => factors.into_iter().map(Feature::everywhere).collect(),
            None => {
                let bubble = self.normalised(|all, x| all.bubble(&x[0], &x[1]));
                let rough = singular(&self.polygon, equation, &self.held()).into_iter();
                let rough = rough.map(Feature::beyond_plane);
                std::iter::once(Feature::everywhere(bubble)).chain(rough).collect()
            }
        };
        for (position, own) in self.edges.iter().enumerate() {
            if own.condition.spring().is_some() {
                let factor = self.normalised(move |all, x| {
                    let weight = all.weights(&x[0], &x[1]).swap_remove(position);
                    let trace = all.edges[position].free_trace(x);
                    trace.map_or_else(|| x[0].constant(0.0), |trace| weight * trace)
                });
                let direction = Some(own.edge.tangent);
                planes.push(Feature { direction, ..Feature::everywhere(factor) });
            }
        }
        for number in 0..self.corners.len() {
            let free = self.corners[number].as_ref().map_or(0, |corner| corner.free.len());
            planes.extend((0..free).map(|mode| {
                let corner = move |all: &Self, x: &[Series; D]| all.corner(number, mode, x);
                Feature::beyond_plane(self.normalised(corner))
            }));
        }
        planes
    }

    /// Term of one free number of a corner.
    fn corner(&self, number: usize, mode: usize, x: &[Series; D]) -> Series {
        let Some(corner) = &self.corners[number] else { return x[0].constant(0.0) };
        let [u, ux, uy] = corner.free[mode];
        let jet = [u, ux / corner.size, uy / corner.size].map(|value| x[0].constant(value));
        let weights = self.weights(&x[0], &x[1]);
        self.edges.iter().zip(weights).fold(x[0].constant(0.0), |sum, (own, weight)| {
            let ends = [own.number, (own.number + 1) % self.corners.len()];
            if !ends.contains(&number) {
                return sum;
            }
            let jets = ends.map(|end| (end == number).then(|| jet.clone()));
            sum + weight * own.function(x, &jets, false)
        })
    }

    /// Vanishes on each edge as often as its condition asks.
    fn bubble(&self, x: &Series, y: &Series) -> Series {
        let level = |contact: usize| -> Vec<usize> {
            let edges = self.edges.iter().filter(|own| own.condition.contact() >= contact);
            edges.map(|own| own.number).collect()
        };
        [level(1), level(2)]
            .iter()
            .filter(|edges| !edges.is_empty())
            .fold(x.constant(1.0), |product, edges| product * self.polygon.feature_of(edges, x, y))
    }

    /// Scaled to size one.
    fn normalised(
        self: &Arc<Self>,
        factor: impl Fn(&Self, &[Series; D]) -> Series + Send + Sync + 'static,
    ) -> Field<D> {
        let own = self.clone();
        normalised(&self.polygon, move |x: &[Series; D]| factor(&own, x))
    }
}
