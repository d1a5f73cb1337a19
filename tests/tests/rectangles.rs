//! Plane beams of the thesis' chapter 2 against an independent program (`fixtures/beam/PROVENANCE.md`).

use sinew_energy::{Load, Parameter, Scene, Support, laws::LinearElastic};
use sinew_fem::{Options, Solver};
use sinew_mesh::{FieldValues, read_npy, rectangle_triangles};
use std::path::PathBuf;

fn floats(name: &str) -> Vec<f64> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/beam/rectangles");
    let array = read_npy(folder.join(name)).expect("the fixture is part of the repository");
    let FieldValues::Float(values) = array.values else { panic!("{name} does not hold floats") };
    values
}

#[test]
fn fields_are_those_of_an_independent_program() {
    let [parameters, points, fields] =
        ["parameters.npy", "points.npy", "displacement.npy"].map(floats);
    let beams = parameters.as_chunks::<4>().0;
    assert_eq!(beams.len(), 4);
    let of_each = points.len() / beams.len();
    let beams = beams.iter().zip(points.chunks(of_each)).zip(fields.chunks(of_each));
    for ((&[length, width, mu, lambda], points), field) in beams {
        let body = Scene::new(rectangle_triangles([length, width], [11, 7]), LinearElastic)
            .parameter(Parameter::linear("mu", "", 4.0..=10.0))
            .parameter(Parameter::linear("lambda", "", 4.0..=10.0))
            .load(Load::BodyForce([0.0, -0.4 * (width / length).powi(2), 0.0]))
            .support(Support::clamped("x_min"))
            .lower()
            .unwrap();
        let solved = Solver::new(&body).unwrap().solve(&[mu, lambda], &Options::default()).unwrap();
        let (mut squares, mut size) = (0.0, 0.0);
        for (place, expected) in points.chunks(2).zip(field.chunks(2)) {
            let apart = |x: &[f64; 3]| (x[0] - place[0]).hypot(x[1] - place[1]);
            let node = (0..body.nodes)
                .min_by(|a, b| apart(&body.positions[*a]).total_cmp(&apart(&body.positions[*b])));
            let node = node.unwrap();
            assert!(apart(&body.positions[node]) < 1e-12);
            let found = &solved.displacement[3 * node..3 * node + 3];
            squares += (found[0] - expected[0]).powi(2) + (found[1] - expected[1]).powi(2);
            size += expected[0].powi(2) + expected[1].powi(2);
            assert_eq!(found[2], 0.0);
        }
        let error = (squares / size).sqrt();
        println!("{length} x {width}: {error:.1e}");
        // Both solve one linear system in double precision; its condition number is about 1e5.
        assert!(error < 1e-9, "{length} x {width}: {error:e}");
    }
}
