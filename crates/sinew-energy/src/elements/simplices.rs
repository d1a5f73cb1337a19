//! Shape functions and rules of linear and quadratic simplices.

/// The linear and the quadratic element of a simplex: nodes, quadrature, finer quadrature and rule of the facets. Corners
/// come first, then the middles of `EDGES`; `SLOPES` are the derivatives of the `barycentric` coordinates.
macro_rules! simplices {
    ($corners:literal: $rule:ident, $fine:ident, $facets:ident;
     $nodes:literal: $quadratic_rule:ident, $quadratic_fine:ident, $quadratic_facets:ident) => {
        impl FiniteElement<$corners> for Nodes<$corners> {
            const QUADRATURE: &'static [QuadraturePoint] = $rule;
            const FINE_QUADRATURE: &'static [QuadraturePoint] = $fine;

            fn shape(at: [f64; 3]) -> [f64; $corners] {
                barycentric(at)
            }

            fn shape_derivatives(_at: [f64; 3]) -> [[f64; 3]; $corners] {
                SLOPES
            }

            fn facet_rule() -> FacetRule {
                FacetRule::$facets()
            }
        }

        impl FiniteElement<$nodes> for Nodes<$nodes> {
            const QUADRATURE: &'static [QuadraturePoint] = $quadratic_rule;
            const FINE_QUADRATURE: &'static [QuadraturePoint] = $quadratic_fine;

            fn shape(at: [f64; 3]) -> [f64; $nodes] {
                let l = barycentric(at);
                std::array::from_fn(|a| match a.checked_sub($corners) {
                    None => l[a] * (2.0 * l[a] - 1.0),
                    Some(edge) => 4.0 * l[EDGES[edge][0]] * l[EDGES[edge][1]],
                })
            }

            fn shape_derivatives(at: [f64; 3]) -> [[f64; 3]; $nodes] {
                let l = barycentric(at);
                std::array::from_fn(|a| {
                    std::array::from_fn(|i| match a.checked_sub($corners) {
                        None => (4.0 * l[a] - 1.0) * SLOPES[a][i],
                        Some(edge) => {
                            let [b, c] = EDGES[edge];
                            4.0 * (l[b] * SLOPES[c][i] + l[c] * SLOPES[b][i])
                        }
                    })
                })
            }

            fn facet_rule() -> FacetRule {
                FacetRule::$quadratic_facets()
            }

            fn corner_shape(at: [f64; 3]) -> Vec<f64> {
                barycentric(at).to_vec()
            }
        }
    };
}
pub(super) use simplices;
