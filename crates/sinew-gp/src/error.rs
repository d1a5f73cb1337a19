//! What can be wrong with a problem, its data, or a fit.

use thiserror::Error;

/// Errors of this crate.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GpError {
    /// An interval without extent.
    #[error("axis {axis} runs from {lower} to {upper}; give finite bounds in ascending order")]
    EmptyAxis {
        /// Name of the axis.
        axis: String,
        /// Its lower end.
        lower: f64,
        /// Its upper end.
        upper: f64,
    },
    /// Two axes of one name.
    #[error("two axes are called {0}; name each axis once")]
    RepeatedAxis(String),
    /// An axis that the domain does not have.
    #[error("there is no axis {name}; the domain has {axes}")]
    UnknownAxis {
        /// The name asked for.
        name: String,
        /// The names there are.
        axes: String,
    },
    /// A polygon that is not simple, or too small.
    #[error("polygon of {vertices} vertices: {problem}")]
    Polygon {
        /// Number of vertices given.
        vertices: usize,
        /// What is wrong and what to do.
        problem: &'static str,
    },
    /// A second condition where there is one already.
    #[error("{face} has a condition already; give value and slope together as a Cauchy condition")]
    OverDetermined {
        /// The face, as `x = 0`.
        face: String,
    },
    /// A condition on a face that the domain does not have as such.
    #[error(
        "{face} is part of the polygon; use `Problem::boundary` for all of its edges, `Problem::edge` for one"
    )]
    PolygonFace {
        /// The face asked for.
        face: String,
    },
    /// A boundary function for a polygon, on a domain without one.
    #[error("the domain has no polygon; give conditions face by face with `Problem::condition`")]
    NoPolygon,
    /// An edge that the polygon does not have.
    #[error("there is no edge {edge}; the polygon has {edges}, numbered from 0")]
    UnknownEdge {
        /// Number asked for.
        edge: usize,
        /// Number of edges.
        edges: usize,
    },
    /// A Robin condition without slope, or with a factor that is no number.
    #[error(
        "the Robin condition on {face} has value factor {value_factor} and slope factor {slope_factor}; both must be finite, and the slope's not 0 (use Dirichlet)"
    )]
    DegenerateRobin {
        /// The face.
        face: String,
        /// Factor of the value.
        value_factor: f64,
        /// Factor of the slope.
        slope_factor: f64,
    },
    /// Conditions of two faces that no function satisfies both.
    #[error(
        "conditions conflict at the corner {corner}: {first} from one face, {second} from the other"
    )]
    ConflictingCorner {
        /// The corner, as `x = 0, t = 0`.
        corner: String,
        /// What the condition of the first face implies for the second functional.
        first: f64,
        /// What the condition of the second face asks for.
        second: f64,
    },
    /// A parameter without room.
    #[error(
        "parameter {name} has bounds [{lower}, {upper}]; give finite bounds in ascending order"
    )]
    ParameterBounds {
        /// Name of the parameter.
        name: String,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// One name with two meanings.
    #[error("parameter {0} is declared twice with different bounds; clone one `Parameter`")]
    ParameterClash(String),
    /// A parameter with a name that the model gives to one of its own.
    #[error("parameter {0} has the name of an amplitude, lengthscale or noise; call it otherwise")]
    ReservedName(String),
    /// A hyperparameter that cannot be adjusted.
    #[error("hyperparameter {name} of the {kernel} kernel: {problem}")]
    Hyperparameter {
        /// Name of the kernel.
        kernel: String,
        /// Name of the hyperparameter.
        name: &'static str,
        /// What is wrong and what to do.
        problem: &'static str,
    },
    /// A periodic kernel without a period.
    #[error("a periodic kernel of period {0}; give a finite one above 0")]
    Period(f64),
    /// A free parameter where only known coefficients will do.
    #[error("parameter {0} is free; networks are trained on equations with known coefficients")]
    FreeParameter(String),
    /// A parameter that the model does not have.
    #[error("there is no parameter {name}; the model has {known}")]
    UnknownParameter {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A derivative of too high an order.
    #[error("derivative of order {order} along {axis}; at most {most} is supported")]
    Order {
        /// Name of the axis.
        axis: String,
        /// Order asked for.
        order: usize,
        /// Highest order.
        most: usize,
    },
    /// A kernel whose functions lack the derivatives that an operator takes.
    #[error(
        "the {kernel} kernel has {has} derivatives, the operator takes {needs}; use a smoother kernel"
    )]
    TooRough {
        /// The kernel.
        kernel: String,
        /// Derivatives in the mean-square sense.
        has: usize,
        /// Highest total order of the operator.
        needs: usize,
    },
    /// Two lists that belong together.
    #[error("{points} points but {values} values")]
    Lengths {
        /// Number of points.
        points: usize,
        /// Number of values.
        values: usize,
    },
    /// Data that are not numbers.
    #[error(
        "{what} number {index} of observation group {group} is {value}; remove it from the data"
    )]
    NotFinite {
        /// `point` or `value`.
        what: &'static str,
        /// Position in the group.
        index: usize,
        /// Number of the group, in the order given.
        group: usize,
        /// The offending number.
        value: f64,
    },
    /// Data at a place that the domain does not have.
    #[error(
        "point {index} of observation group {group} ({point:?}) lies outside the domain; check its unit, or remove it"
    )]
    OutsideDomain {
        /// Position in the group.
        index: usize,
        /// Number of the group, in the order given.
        group: usize,
        /// The point.
        point: Vec<f64>,
    },
    /// A feature, mean or coefficient that has no derivative at a point.
    #[error(
        "the {what} has no finite value or derivative at point {index} of observation group {group} ({point:?}); move the point off the corner, or make the formula finite there"
    )]
    Singular {
        /// What is singular.
        what: &'static str,
        /// Position in the group.
        index: usize,
        /// Number of the group.
        group: usize,
        /// The point.
        point: Vec<f64>,
    },
    /// The same at a point where a prediction is asked for.
    #[error(
        "the {what} has no finite value or derivative at point {index} of the prediction ({point:?}); move the point off the corner, or make the formula finite there"
    )]
    SingularPrediction {
        /// What is singular.
        what: &'static str,
        /// Position among the points.
        index: usize,
        /// The point.
        point: Vec<f64>,
    },
    /// A prediction at a place that is no number, or with such a weight.
    #[error("{what} number {index} of the prediction is {value}; give a finite one")]
    NotFinitePrediction {
        /// `point` or `weight`.
        what: &'static str,
        /// Position in the list.
        index: usize,
        /// The offending number.
        value: f64,
    },
    /// A share of probability that is none.
    #[error("an interval of level {0}; give a number between 0 and 1, as 0.95")]
    Level(f64),
    /// A group whose noise cannot be learned, for nothing was observed.
    #[error(
        "observation group {group} has no points, so that its noise cannot be learned; leave it out"
    )]
    EmptyGroup {
        /// Number of the group, in the order given.
        group: usize,
    },
    /// Two noise-free values of the same at the same point.
    #[error(
        "values {first} and {second} of observation group {group} are noise-free, belong to one point and differ by {difference}; keep one, or give them noise"
    )]
    Duplicates {
        /// Position of one of them in the group.
        first: usize,
        /// Position of the other.
        second: usize,
        /// Number of the group, in the order given.
        group: usize,
        /// Second less first.
        difference: f64,
    },
    /// A noise-free observation where the prior leaves no freedom, off its value.
    #[error(
        "value {index} of observation group {group} is noise-free and off by {residual} where the boundary conditions fix it; correct it or give it noise"
    )]
    Contradiction {
        /// Position in the group.
        index: usize,
        /// Number of the group.
        group: usize,
        /// Observed minus prescribed.
        residual: f64,
    },
    /// A noise level that is negative or not a number.
    #[error("noise of standard deviation {0}; give a finite one above 0, or `Noise::Exact`")]
    Noise(f64),
    /// Nothing to condition on.
    #[error("the model has no observations; add values or an equation")]
    NoData,
    /// Conditional evidence without anything to predict.
    #[error(
        "conditional evidence needs observations of u beside those of the equation; use joint evidence"
    )]
    NothingConditional,
    /// Parameters in single precision.
    #[error("parameters must be a tensor of double precision; cast it to F64")]
    Precision,
    /// A covariance matrix that stays indefinite.
    #[error(
        "the covariance of {size} observations is not positive definite even with a relative jitter of {jitter:e}; remove duplicate noise-free points or add noise"
    )]
    NotPositiveDefinite {
        /// Number of observations.
        size: usize,
        /// Largest relative jitter tried.
        jitter: f64,
    },
    /// A parameter vector of wrong length.
    #[error("{found} parameters given, the model has {expected}")]
    ParameterCount {
        /// Number given.
        found: usize,
        /// Number needed.
        expected: usize,
    },
    /// A variational bound of an equation without noise.
    #[error(
        "the equation holds exactly in these data, where no normal distribution has a finite variational bound; give its values `Noise::Learned`, or a known noise"
    )]
    ExactEquation,
    /// A nonlinear term that is not finite where u may be.
    #[error(
        "the nonlinear term has no finite value or derivative near {arguments:?}, its arguments at point {index}; start from a solution that is better known, or define the term there"
    )]
    Term {
        /// Number of the point, in the order given; of collocation points where an equation is solved.
        index: usize,
        /// Means of the arguments there.
        arguments: Vec<f64>,
    },
    /// An ensemble without draws: none were asked for, or all were removed.
    #[error("the ensemble has no draws; keep at least one")]
    NoDraws,
    /// A fit from given starts without any.
    #[error("no starts are given; give one at least, or let `Model::fit` draw some")]
    NoStarts,
    /// No restart of a fit succeeded.
    #[error("none of {restarts} restarts reached a finite evidence; last: {last}")]
    NoFit {
        /// Restarts tried.
        restarts: usize,
        /// Error of the last one.
        last: Box<GpError>,
    },
    /// A polygon that random points hardly ever hit.
    #[error("the domain's polygon has too small a share of its bounding box to sample from")]
    Sampling,
}
