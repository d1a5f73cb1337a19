//! Rule-based fibres against closed forms, symmetry and a published field.

mod ellipsoid;
mod potentials;

use crate::ventricles::ventricles;
use nalgebra::{Matrix3, Rotation3, Vector3};
use sinew_fem::fibres::{
    EllipsoidWall, FibreError, FibreRule, Frame, Surfaces, VentricleCoordinates,
};
use sinew_mesh::{TetMesh, TruncatedEllipsoid, box_tetrahedra, repair_orientation};

const SURFACES: Surfaces<'static> =
    Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };

/// Centres of cells on a coarse mesh lie this far in the cavity [of the thickness].
const SLACK: f64 = 0.1;

fn land(cells: [usize; 3]) -> TetMesh {
    TruncatedEllipsoid::LAND.wall(cells).tetrahedra()
}

fn centre(mesh: &TetMesh, cell: usize) -> [f64; 3] {
    (mesh.corners(cell).iter().sum::<Vector3<f64>>() / 4.0).into()
}

/// Angle [degrees] between two lines.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (Vector3::from(a), Vector3::from(b));
    a.cross(&b).norm().atan2(a.dot(&b).abs()).to_degrees()
}

/// The value that the given part of all values do not exceed.
fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(part * (values.len() - 1) as f64).round() as usize]
}

/// Angles [degrees] between frames and those in closed form.
fn errors(frames: &[Frame], points: &[[f64; 3]], direction: usize) -> Vec<f64> {
    let error = |(frame, &point): (&Frame, &[f64; 3])| {
        let exact = EllipsoidWall::LAND.frame(point, &FibreRule::SIXTY, SLACK).unwrap();
        angle(frame[direction], exact[direction])
    };
    frames.iter().zip(points).map(error).collect()
}

/// Median and 95 % quantile of the fibres' errors in cells, then at nodes.
fn fibre_errors(cells: [usize; 3]) -> [[f64; 2]; 2] {
    let mesh = land(cells);
    let wall = VentricleCoordinates::new(&mesh, &SURFACES).unwrap();
    let centres: Vec<_> = (0..mesh.cells.len()).map(|cell| centre(&mesh, cell)).collect();
    let of_cells = wall.cell_frames(&FibreRule::SIXTY);
    let of_nodes = wall.node_frames(&FibreRule::SIXTY);
    let sheets = quantile(&mut errors(&of_cells, &centres, 1), 0.5);
    let both = [errors(&of_cells, &centres, 0), errors(&of_nodes, &mesh.points, 0)];
    let both = both.map(|mut errors| [0.5, 0.95].map(|part| quantile(&mut errors, part)));
    println!(
        "{cells:?}: fibres [50 %, 95 %] in cells {:.2?}, at nodes {:.2?}; sheets {sheets:.2} degrees",
        both[0], both[1]
    );
    both
}

#[test]
fn fibres_converge_to_the_closed_form() {
    let coarse = fibre_errors([3, 24, 12]);
    let fine = fibre_errors([6, 48, 24]);
    for (coarse, fine) in coarse.iter().zip(&fine) {
        // Half the size of cells: first order at least.
        assert!(fine[0] < 0.6 * coarse[0], "{fine:?} against {coarse:?}");
        assert!(fine[0] < 1.0 && fine[1] < 2.5, "{fine:?}");
    }
}

#[test]
fn frames_are_orthonormal_everywhere() {
    let mesh = land([2, 16, 8]);
    let wall = VentricleCoordinates::new(&mesh, &SURFACES).unwrap();
    let rule = FibreRule::new(-90.0, 90.0).unwrap().with_sheets(-65.0, 25.0).unwrap();
    let (cells, nodes) = (wall.cell_frames(&rule), wall.node_frames(&rule));
    assert_eq!((cells.len(), nodes.len()), (mesh.cells.len(), mesh.points.len()));
    for frame in cells.iter().chain(&nodes) {
        let frame = Matrix3::from_columns(&frame.map(Vector3::from));
        assert!((frame.transpose() * frame - Matrix3::identity()).amax() < 1e-12);
        assert!((frame.determinant() - 1.0).abs() < 1e-12, "right-handed");
    }
}

#[test]
fn potentials_stay_between_their_ends() {
    let mesh = land([3, 24, 12]);
    let wall = VentricleCoordinates::new(&mesh, &SURFACES).unwrap();
    let ends = |values: &[f64]| {
        values.iter().fold((1.0_f64, 0.0_f64), |(least, most), &v| (least.min(v), most.max(v)))
    };
    for values in [&wall.thickness, &wall.longitudinal] {
        assert_eq!(ends(values), (0.0, 1.0));
    }
    for apex in ["apex_endo", "apex_epi"] {
        assert_eq!(wall.longitudinal[mesh.node_sets[apex][0]], 0.0);
    }
}

#[test]
fn frames_turn_with_the_mesh() {
    let mut mesh = land([2, 16, 8]);
    let frames = |mesh: &TetMesh| {
        let wall = VentricleCoordinates::new(mesh, &SURFACES).unwrap();
        let mut frames = wall.cell_frames(&FibreRule::SIXTY);
        frames.extend(wall.node_frames(&FibreRule::SIXTY));
        frames
    };
    let before = frames(&mesh);
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for point in &mut mesh.points {
        *point = (turn * Vector3::from(*point) * 2.5 + Vector3::new(40.0, -3.0, 7.0)).into();
    }
    for (before, after) in before.iter().zip(&frames(&mesh)) {
        for (a, b) in before.iter().zip(after) {
            assert!((turn * Vector3::from(*a) - Vector3::from(*b)).norm() < 1e-9);
        }
    }
}

#[test]
fn a_real_ventricle_was_published_with_such_fibres() {
    // The small one has its fibres by this very rule.
    let all = ventricles();
    let Some((_, mesh)) = all.iter().find(|(name, _)| *name == "published") else { return };
    let published = mesh.cell_fields["fibre"].to_vectors::<3>().unwrap();
    let surfaces = Surfaces { endocardium: "region:1", epicardium: "epicardium", base: "base" };
    let wall = VentricleCoordinates::new(mesh, &surfaces).unwrap();
    let axes = wall.cell_frames(&FibreRule::new(0.0, 0.0).unwrap());
    let mut tilts = Vec::new();
    let mut angles = vec![Vec::new(); 10];
    for (cell, (nodes, frame)) in mesh.cells.iter().zip(&axes).enumerate() {
        let depth = nodes.iter().map(|&node| wall.thickness[node]).sum::<f64>() / 4.0;
        // Without an angle the frame is circumferential, outward and away from the base.
        let fibre = Vector3::from(published[cell]);
        let [around, outward, down] = frame.map(|axis| fibre.dot(&Vector3::from(axis)));
        tilts.push(outward.abs().asin().to_degrees());
        angles[(10.0 * depth) as usize].push((-down / around).atan().to_degrees());
    }
    let tilt = quantile(&mut tilts, 0.5);
    println!("tilt out of the layers: median {tilt:.2}, 90 % {:.2}", quantile(&mut tilts, 0.9));
    assert!(tilt < 2.5, "published fibres lie in our layers");
    let quartiles = |angles: &mut Vec<f64>| [0.25, 0.5, 0.75].map(|part| quantile(angles, part));
    let angles: Vec<_> = angles.iter_mut().map(quartiles).collect();
    for (tenth, [low, median, high]) in angles.iter().enumerate() {
        println!("tenth {tenth}: angle {median:.1} ({low:.1} to {high:.1}) degrees");
        assert!(high - low < 15.0, "their angle depends on our depth alone");
    }
    // The rule of +60 to −60 degrees, with another measure of the depth inside.
    assert!(angles.windows(2).all(|pair| pair[1][1] < pair[0][1]), "it falls from the endocardium");
    assert!(angles[0][1] > 50.0 && angles[9][1] < -40.0);
}

fn refusal(mesh: &TetMesh) -> FibreError {
    VentricleCoordinates::new(mesh, &SURFACES).unwrap_err()
}

#[test]
fn walls_that_are_not_bounded_are_refused() {
    let good = land([1, 8, 4]);

    let mut mesh = good.clone();
    mesh.facet_sets.remove("epi");
    let error = refusal(&mesh);
    assert!(matches!(&error, FibreError::UnknownSurface { name, .. } if name == "epi"));
    assert!(error.to_string().contains("endo"), "names what there is: {error}");

    let mut mesh = good.clone();
    mesh.facet_sets.insert("base".into(), vec![]);
    assert_eq!(refusal(&mesh), FibreError::EmptySurface { name: "base".into() });

    let mut mesh = good.clone();
    let base = mesh.facet_sets["base"].clone();
    mesh.facet_sets.get_mut("endo").unwrap().extend(&base);
    let shared = mesh.nodes_of_facets(&base).len() / 2;
    let text = refusal(&mesh).to_string();
    assert!(
        text.starts_with(&format!("endocardium and epicardium share {shared} nodes")),
        "{text}"
    );

    let mut mesh = good.clone();
    let all = [&good.facet_sets["epi"][..], &good.facet_sets["endo"]].concat();
    mesh.facet_sets.insert("base".into(), all);
    assert!(refusal(&mesh).to_string().starts_with("there is no apex: all "));
    assert_eq!(
        refusal(&TetMesh::default()),
        FibreError::Unfit("the mesh has no tetrahedra".into())
    );
}

#[test]
fn cells_that_are_no_part_of_the_wall_are_refused() {
    let good = land([1, 8, 4]);
    let mut mesh = TetMesh { point_fields: Default::default(), ..good.clone() };
    let first = mesh.points.len();
    let block = box_tetrahedra([1.0; 3], [1; 3]);
    mesh.points.extend(&block.points);
    mesh.cells.extend(block.cells.iter().map(|cell| cell.map(|node| first + node)));
    assert_eq!(
        refusal(&mesh),
        FibreError::Unfit(format!(
            "the part of the mesh with node {first} (8 nodes) has no node on `endo`; remove it, or mesh the ventricle in one piece"
        ))
    );

    let mut mesh = good.clone();
    mesh.cells[7].swap(0, 1);
    assert!(refusal(&mesh).to_string().starts_with("cell 7 has the volume -"));
    assert_eq!(repair_orientation(&mut mesh), 1);
    assert!(VentricleCoordinates::new(&mesh, &SURFACES).is_ok());

    let mut mesh = good;
    mesh.points[3][1] = f64::NAN;
    assert!(matches!(refusal(&mesh), FibreError::Mesh(_)));
}
