//! Probable mistakes in a case that can be solved: sizes, stiffnesses and supports outside those of soft tissue.

use super::Case;
use super::mesh::MICROMETRE;
use super::units::{length_within, size};
use crate::output::{least_and_largest_ratio, mean_and_largest};
use crate::theta::theta_in_words;
use sinew_emulate::parts::dot;
use sinew_emulate::{Emulator, Simulations, Warning};
use sinew_energy::{Body, Mat3};
use sinew_fem::{LockingWarning, SolveError, locking};
use sinew_mesh::{AnyMesh, self_intersections};
use sinew_num::in_parallel;

/// Smallest and largest size of a body [mm]: a millimetre of tissue and a metre, the length of a leg.
const SIZES: [f64; 2] = [1.0, 1e3];

/// Smallest and largest shear modulus [kPa]: an embryo's tissue has 0.1, a tendon 1e5 at most.
const STIFFNESSES: [f64; 2] = [0.01, 1e5];

/// Largest displacement \[relative to the size of the body\] below which the body counts as at rest.
const LEAST_MOTION: f64 = 1e-6;

/// Largest displacement \[relative to the size of the body, beyond what supports prescribe\] that loads in the right units cause.
const MOST_MOTION: f64 = 2.0;

/// Volume ratio J below which the stress of a cell is doubtful: laws of soft tissue are fitted to volumes that hardly change.
const LEAST_RATIO: f64 = 0.2;

/// Displacements between neighbours that probe forces \[relative to the size of the smallest cell\]: small strains.
const PROBE: f64 = 1e-3;

/// Change of the forces that is a rounding error \[relative to them\].
const NO_CHANGE: f64 = 1e-12;

/// Parts of a mesh that touch or overlap without common nodes, in words.
fn contacts(mesh: &AnyMesh) -> impl Iterator<Item = String> {
    let hanging = mesh.hanging_nodes();
    let hanging = hanging.first().map(|[node, cell]| {
        format!(
            "{} of its nodes lie on cells that they do not belong to, node {node} on cell {cell} first; parts that touch or overlap move independently: join them by common nodes",
            hanging.len()
        )
    });
    let (surface, of_cells) = mesh.boundary_surface();
    let crossing = self_intersections(&surface);
    let crossing = crossing.first().map(|pair| {
        let [a, b] = pair.map(|triangle| of_cells[triangle]);
        format!(
            "its surface passes through itself in {} pairs of triangles, of cells {a} and {b} first; parts that overlap count twice: leave one out",
            crossing.len()
        )
    });
    let enclosed = || {
        let parts = mesh.enclosed_parts();
        let cell = parts.first()?;
        Some(format!(
            "parts of it lie inside others without common nodes, {} in all, the first with cell {cell}; both count there: leave one out, or cut the place of the inner one out of the other",
            parts.len()
        ))
    };
    hanging.into_iter().chain(crossing.or_else(enclosed))
}

impl Case {
    /// Warnings about fibres that the law does not read, and about loads and springs of zero.
    pub(super) fn without_effect(&self) -> impl Iterator<Item = String> {
        let law = self.law.row(&self.source).ok().filter(|law| law.directions == 0);
        let unread = law.zip(self.fibres.as_ref()).map(|(law, _)| {
            let name = law.name;
            let reason = format!(
                "`{name}` is isotropic and reads none; remove [fibres], or take a law along fibres"
            );
            self.source.error(&["fibres"], reason).to_string()
        });
        let is_zero = |load: &super::Load| {
            let vector = load.body_force.or(load.traction).map(|vector| vector.0);
            let springs = load.foundation.map(|springs| [springs.normal, springs.tangential]);
            vector == Some([0.0; 3]) || springs == Some([0.0; 2])
        };
        let idle = self.loads.iter().enumerate().filter(move |(_, load)| is_zero(load));
        unread.into_iter().chain(idle.map(|(number, _)| {
            let reason = "it is zero and does nothing; give another value, or remove it";
            self.source.error(&["loads", &number.to_string()], reason.into()).to_string()
        }))
    }

    /// Warnings about units, supports, loads and parameters.
    pub(super) fn doubts(&self, body: &Body) -> Vec<String> {
        let size = size(&body.positions);
        let key = |keys: &[&str], reason: String| self.source.error(keys, reason).to_string();
        let mut warnings = Vec::new();
        let [least, most] = SIZES;
        if !(least..=most).contains(&size) {
            let (size, advice) = (rounded(size), self.fitting_unit(size));
            let reason = format!(
                "the body is {size} mm in size, and tissue is between {least} and {most} mm; {advice}"
            );
            warnings.push(key(&["mesh"], reason));
        }
        let moduli = [moduli(body, 0), moduli(body, 1)];
        // Poisson's ratio is negative.
        let swells = |[shear, bulk]: &[f64; 2]| 1.5 * bulk < (1.0 - NO_CHANGE) * shear;
        if let Some(moduli) = moduli.into_iter().find(swells) {
            let [shear, bulk] = moduli.map(rounded);
            let reason = format!(
                "the bulk modulus at rest is {bulk} kPa and the shear modulus {shear} kPa, so that the body grows thicker where it is pulled; if the first is in another unit, give it in kPa"
            );
            warnings.push(key(&["law", "bulk_modulus"], reason));
        }
        let [least, most] = STIFFNESSES;
        let unlikely =
            |shear: &f64| *shear > 0.0 && shear.is_finite() && !(least..=most).contains(shear);
        if let Some(stiffness) = moduli.map(|[shear, _]| shear).into_iter().find(unlikely) {
            let stiffness = rounded(stiffness);
            let reason = format!(
                "the shear modulus at rest is {stiffness} kPa within the ranges, and tissue is between {least} and {most} kPa; if they are in \
                 another unit, say so: {{ range = […], unit = \"Pa\" }}"
            );
            warnings.push(key(&["parameters"], reason));
        }
        warnings.extend(contacts(&body.mesh).map(|reason| key(&["mesh"], reason)));
        if body.free_nodes().is_empty() {
            let reason = "they hold every node in every direction, so that nothing can move; hold fewer nodes";
            warnings.push(key(&["supports"], reason.into()));
        }
        let is_pressure =
            |load: &&super::Load| load.pressure.is_some() || load.thesis_pressure.is_some();
        // The body has no forces of a pressure without a potential.
        let has_all = self.loads.iter().filter(is_pressure).count() == body.pressures.len();
        if has_all && !body.free_nodes().is_empty() {
            match idle_parameters(body) {
                None => {
                    let reason = format!("nothing moves the body, so that all displacements are zero; {LOOK}");
                    warnings.push(key(&["loads"], reason));
                }
                Some(names) => warnings.extend(names.iter().map(|name| {
                    let reason = "its value changes no displacement; look at the loads and sets that it acts on, or give it as a number";
                    key(&["parameters", name], reason.into())
                })),
            }
        }
        warnings
    }

    /// Advice about the unit of a mesh that makes a body of a size \[mm\] that no tissue has.
    fn fitting_unit(&self, size: f64) -> String {
        let scale = self.mesh.scale(&self.source).unwrap_or(1.0);
        let converted = self.mesh.report.get().is_some_and(|report| report.in_micrometres);
        let bare = size / if converted { MICROMETRE } else { scale };
        let fits = (SIZES[0]..=SIZES[1]).contains(&bare);
        match (length_within(bare, SIZES), &self.mesh.unit) {
            (_, Some(unit)) if fits => {
                format!(
                    "if its lengths are in mm, write \"mm\" in place of unit = \"{unit}\" under [mesh]"
                )
            }
            (Some(unit), _) => {
                format!(
                    "if its lengths are in another unit, say so: unit = \"{unit}\" under [mesh]"
                )
            }
            (None, _) => {
                "no unit of length makes it one, so look at the numbers of the mesh".into()
            }
        }
    }
}

/// Advice where nothing moves.
const LOOK: &str = "look at the loads and at their units: kPa, and kPa/mm for forces per volume";

/// Names of the parameters that change no displacement, by the forces at small strains; `None` where no load moves the body at all.
fn idle_parameters(body: &Body) -> Option<Vec<String>> {
    let free = body.free_degrees_of_freedom();
    // Without springs, which read no parameter, and beside which others may be rounding errors.
    let forces = |displacement: &[f64], theta: &[f64]| -> Vec<f64> {
        let mut gradient: Vec<f64> = body.nodal_force.iter().map(|force| -force).collect();
        let (law, barriers) = (body.law_parameters(theta), body.barriers.as_ref());
        let law = |point: usize, h: &Mat3<f64>| Some(body.material.stress(point, law, h, barriers));
        body.add_stress_forces(displacement, law, &mut gradient);
        for pressure in &body.pressures {
            pressure.value_and_add_gradient(displacement, theta, &mut gradient);
        }
        free.iter().map(|&dof| body.frames.component(dof, &gradient)).collect()
    };
    let norm = |forces: &[f64]| dot(forces, forces).sqrt();
    let length = body.volumes.iter().copied().fold(f64::INFINITY, f64::min);
    let step = PROBE * length.powf(1.0 / body.element().dimension as f64);
    let probe: Vec<f64> = (0..3 * body.nodes).map(|i| step * (i as f64).sin()).collect();
    let (rest, centre) = (vec![0.0; probe.len()], body.centre());
    let own = forces(&probe, &centre);
    let end = |end: usize| body.parameters.iter().map(|p| p.range[end]).collect::<Vec<_>>();
    let is_loaded =
        [end(0), end(1)].iter().any(|theta| norm(&forces(&rest, theta)) > NO_CHANGE * norm(&own));
    if !is_loaded && body.prescribed.iter().flatten().all(|u| *u == 0.0) {
        return None;
    }
    let is_idle = |&index: &usize| {
        let mut theta = centre.clone();
        theta[index] = body.parameters[index].range[1];
        let other = forces(&probe, &theta);
        // Without loads and springs a common factor of all forces changes no displacement.
        let is_free = !is_loaded && body.springs.is_empty();
        let factor = if is_free { dot(&own, &other) / dot(&own, &own) } else { 1.0 };
        let change = own.iter().zip(&other).map(|(own, other)| other - factor * own);
        let varies = body.parameters[index].range[0] < body.parameters[index].range[1];
        varies && norm(&change.collect::<Vec<_>>()) <= NO_CHANGE * norm(&other)
    };
    let idle = (0..body.parameters.len()).filter(is_idle);
    Some(idle.map(|index| body.parameters[index].name.clone()).collect())
}

/// Warnings about displacements: all almost zero, one beyond the size of the body, and cells that lose most of their volume.
pub fn doubtful_displacements(body: &Body, fields: &[&[f64]]) -> Vec<String> {
    // One without a load among others with one is no mistake.
    let still = fields.iter().map(|field| negligible_displacement(body, field));
    let still = still.collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().next());
    let largest = |u: f64, other: &f64| u.max(other.abs());
    let (prescribed, size) =
        (body.prescribed.iter().flatten().fold(0.0, largest), size(&body.positions));
    let most = fields.iter().copied().flatten().fold(0.0, largest);
    let far = (most > MOST_MOTION * size + prescribed).then(|| {
        let (most, size) = (rounded(most), rounded(size));
        let unit = &body.units.length;
        format!("the largest displacement is {most} {unit}, and the body's size is {size} {unit}; {LOOK}")
    });
    let least = in_parallel(fields, |field| least_and_largest_ratio(body, field)[0]);
    let doubtful = least.iter().filter(|ratio| **ratio < LEAST_RATIO).count();
    let squeezed = (doubtful > 0).then(|| {
        let (least, all) = (least.into_iter().fold(f64::INFINITY, f64::min), fields.len());
        let least = rounded(least);
        format!(
            "the volume ratio J falls to {least} (below {LEAST_RATIO} in {doubtful} of {all} displacements): look at the cells there, and take finer or \
             averaged ones, a larger bulk modulus or a smaller load, before stresses are read"
        )
    });
    still.into_iter().chain(far).chain(squeezed).collect()
}

/// [`doubtful_displacements`] of an emulator, in the middle of the ranges and beside it.
///
/// # Errors
/// An emulator that cannot predict.
pub fn doubtful_emulator(emulator: &Emulator<'_>) -> Result<Vec<String>, sinew_emulate::Error> {
    let body = emulator.body();
    let probes = emulator.predict(&[body.centre(), body.beside_centre()])?;
    Ok(doubtful_displacements(body, &[probes.field(0), probes.field(1)]))
}

/// Warnings about solutions that are unstable, and that a rising load does not lead to; `cure` raises the load step by step.
pub fn branched_in_words(body: &Body, found: &Simulations, cure: &str) -> Vec<String> {
    let unstable = found.unstable.first().map(|first| {
        let (count, first) = (found.unstable.len(), theta_in_words(body, first));
        format!(
            "{count} of {} solutions, the first at {first}, are {}",
            found.fields.len(),
            Warning::Unstable
        )
    });
    unstable.into_iter().chain(of_other_branches(body, found, cure)).collect()
}

fn of_other_branches(body: &Body, found: &Simulations, cure: &str) -> Option<String> {
    let first = theta_in_words(body, found.branched.first()?);
    let Simulations { branched, jumped, compared, fields, .. } = found;
    let (count, all) = (branched.len(), fields.len());
    let among =
        if *compared >= count { format!("the {compared} compared") } else { all.to_string() };
    let open = match jumped.len().saturating_sub(count) {
        0 => String::new(),
        open => format!("; {open} others, which were not compared, may not be either"),
    };
    Some(format!(
        "{count} of {among} solutions are not those that a rising load leads to, the first at {first}{open}: the body has several stable equilibria; \
         {cure} raises the load step by step"
    ))
}

/// Warning about a displacement that is almost zero; `None` where everything is held.
pub fn negligible_displacement(body: &Body, displacement: &[f64]) -> Option<String> {
    let ([_, largest], size) = (mean_and_largest(displacement), size(&body.positions));
    let hardly = largest < LEAST_MOTION * size && !body.free_nodes().is_empty();
    let unit = &body.units.length;
    hardly.then(|| {
        format!(
            "the largest displacement is {largest:.1e} {unit}, less than a millionth of the body's size of {} {unit}; {LOOK}",
            rounded(size)
        )
    })
}

/// Moduli of shear and of volume at rest, at one end of all ranges.
fn moduli(body: &Body, end: usize) -> [f64; 2] {
    let theta: Vec<f64> = body.parameters.iter().map(|p| p.range[end]).collect();
    let response = body.material.response(0, body.law_parameters(&theta), &Mat3::ZERO);
    // Means of ∂P_ij/∂H_ij over i ≠ j, and of ∂P_ii/∂H_jj.
    let shear = (0..9).filter(|row| row % 4 != 0).map(|row| response.tangent[row][row]);
    let volume = [0, 4, 8].map(|i| [0, 4, 8].map(|j| response.tangent[i][j]));
    [shear.sum::<f64>() / 6.0, volume.as_flattened().iter().sum::<f64>() / 9.0]
}

fn rounded(value: f64) -> String {
    sinew_report::format::trimmed(value, 3)
}

/// [`locking`] at the state that [`moved_most`] finds; none without any.
///
/// # Errors
/// As for [`locking`].
pub fn locking_at_most<'a>(
    body: &Body,
    states: impl IntoIterator<Item = (&'a Vec<f64>, &'a [f64])>,
) -> Result<Option<LockingWarning>, SolveError> {
    let most = moved_most(body, states);
    most.map_or(Ok(None), |(theta, field)| locking(body, theta, field))
}

/// θ and displacement of the largest mean square displacement that inverts no cell; none without any.
pub fn moved_most<'a>(
    body: &Body,
    states: impl IntoIterator<Item = (&'a Vec<f64>, &'a [f64])>,
) -> Option<(&'a Vec<f64>, &'a [f64])> {
    let admitted = states.into_iter().filter(|(_, field)| body.admits(field));
    admitted.max_by(|(_, a), (_, b)| dot(a, a).total_cmp(&dot(b, b)))
}

/// Text of a warning of [`locking`] for the author of a case file: how much of the displacement is expected
/// to be lost, why, and which key cures it.
///
/// ```
/// use sinew::{Case, locking_in_words};
///
/// let case = Case::parse(sinew::scenes::SCENES[0].text, "beam.toml")?;
/// let warning = sinew_fem::locking_at_centre(&case.body()?)?.expect("linear tetrahedra lock");
/// assert!(locking_in_words(&warning).contains("formulation = \"quadratic\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn locking_in_words(warning: &LockingWarning) -> String {
    let cure = match (warning.element.corners, warning.bulk_to_shear) {
        (8, Some(_)) => "write formulation = \"averaged\" in the case file",
        (8, None) => {
            "divide the body more finely, or take tetrahedra with formulation = \"quadratic\""
        }
        _ => "write formulation = \"quadratic\" in the case file",
    };
    format!("{}; {cure}; `sinew solve --check-mesh` measures what is lost", warning.reason())
}
