//! Membranes whose edges do not all hold values, or that are not convex: conditions imposed at points.

use sinew_gp::{
    Data, Derivative, Domain, Evidence, FitOptions, GpError, Model, Noise, Operator, Prior,
    Problem, Series, squared_exponential,
};
use std::f64::consts::PI;

/// u = sin x cosh(y / 2), −Δu = ¾ u.
fn exact([x, y]: [f64; 2]) -> f64 {
    x.sin() * (0.5 * y).cosh()
}

fn slope([x, y]: [f64; 2], [nx, ny]: [f64; 2]) -> f64 {
    x.cos() * (0.5 * y).cosh() * nx + x.sin() * (0.5 * y).sinh() * 0.5 * ny
}

/// Points along the edge between two corners, and its outward normal.
fn edge([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> (Vec<[f64; 2]>, [f64; 2]) {
    const COUNT: u32 = 8;
    let length = (bx - ax).hypot(by - ay);
    let along = (0..COUNT).map(|k| (f64::from(k) + 0.5) / f64::from(COUNT));
    let points = along.map(|s| [ax + s * (bx - ax), ay + s * (by - ay)]).collect();
    (points, [(by - ay) / length, (ax - bx) / length])
}

/// Largest error over the range of u, with values on even edges, slopes and springs by turns on odd ones.
fn error(domain: &Domain<2>, corners: &[[f64; 2]], at: &[[f64; 2]]) -> Result<f64, GpError> {
    let [dx, dy] = domain.derivatives();
    let mut data = Data::new();
    for (number, corner) in corners.iter().enumerate() {
        let (points, [nx, ny]) = edge(*corner, corners[(number + 1) % corners.len()]);
        let flux: Operator<2> = nx * dx + ny * dy;
        let (operator, value_factor, slope_factor) = match number % 4 {
            0 | 2 => (Derivative::identity().into(), 1.0, 0.0),
            1 => (flux, 0.0, 1.0),
            _ => (2.0 * flux + Derivative::identity(), 1.0, 2.0),
        };
        let held = |x: &[f64; 2]| value_factor * exact(*x) + slope_factor * slope(*x, [nx, ny]);
        let values: Vec<f64> = points.iter().map(held).collect();
        data = data.imposed(operator, &points, &values, Noise::Exact);
    }
    let load: Vec<f64> = at.iter().map(|x| 0.75 * exact(*x)).collect();
    let data = data.equation(at, &load, Noise::Exact);
    let problem = Problem::new(domain.clone(), -(dx * dx) - dy * dy)?;
    let prior = Prior::constrained(&problem, &squared_exponential())?;
    let options = FitOptions { most_points: 0, ..FitOptions::default() };
    let fit = Model::new(prior, data, Evidence::Auto)?.fit(&options)?;
    let mean = fit.conditional()?.mean(at)?;
    Ok(mean.iter().zip(at).map(|(m, x)| (m - exact(*x)).abs()).fold(0.0, f64::max))
}

#[test]
fn membranes_with_mixed_edges_and_notches_are_solved_at_points() -> Result<(), GpError> {
    let angle = |k: u32| PI / 2.0 + 0.4 * PI * f64::from(k);
    let pentagon: Vec<[f64; 2]> = (0..5).map(|k| [angle(k).cos(), angle(k).sin()]).collect();
    let domain = Domain::polygon(["x", "y"], &pentagon)?;
    let off = error(&domain, &pentagon, &domain.sample(60, 3)?)?;
    let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let around = Domain::cuboid([("x", [0.0, 2.0]), ("y", [0.0, 2.0])])?;
    let mut at = around.sample(80, 3)?;
    at.retain(|[x, y]| *x < 1.0 || *y < 1.0);
    let notch = error(&around, &notched, &at)?;
    println!("largest error of u: pentagon {off:.1e}, L {notch:.1e}");
    assert!(off < 1e-4 && notch < 1e-4, "{off:e} {notch:e}");
    Ok(())
}

/// Pseudo-observations of the values on a polygon's boundary, beside the edges that hold them exactly.
#[test]
fn values_on_a_polygon_are_held_or_observed() -> Result<(), GpError> {
    let domain = Domain::polygon(["x", "y"], &[[0.0, 0.0], [1.5, 0.0], [1.0, 1.0], [0.0, 1.2]])?;
    let [dx, dy] = domain.derivatives();
    let rim = sinew_gp::field(|[x, y]: [Series; 2]| {
        let (up, down) = ((&y * 0.5).exp(), (&y * -0.5).exp());
        x.sin() * (up + down) * 0.5
    });
    let problem = Problem::new(domain.clone(), -(dx * dx) - dy * dy)?.boundary(rim)?;
    let at = domain.sample(40, 3)?;
    let load: Vec<f64> = at.iter().map(|x| 0.75 * exact(*x)).collect();
    let kernel = squared_exponential();
    let mut off = Vec::new();
    for prior in
        [Prior::constrained(&problem, &kernel)?, Prior::penalised(&problem, &kernel, 24, 1)?]
    {
        let data = Data::new().equation(&at, &load, Noise::Exact);
        let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
        let rim: Vec<[f64; 2]> = (0..4)
            .map(|number| domain.cross_section().expect("a polygon").on_edge(number, 0.37))
            .collect();
        let mean = fit.conditional()?.mean(&rim)?;
        let each = mean.iter().zip(&rim).map(|(m, x)| (m - exact(*x)).abs());
        off.push(each.fold(0.0, f64::max));
    }
    println!("on the boundary off by {:.1e} and {:.1e}", off[0], off[1]);
    assert!(off[0] < 1e-14 && off[1] < 1e-2, "{off:?}");
    Ok(())
}
