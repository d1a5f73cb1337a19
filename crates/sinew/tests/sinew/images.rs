//! Bodies from images: walls between surfaces, and bodies at rest of loaded ones.

use crate::program::{BAR, bar, done, refused};
use std::path::Path;

/// Surfaces of a ventricle of a few millimetres, as tools of the field write them.
fn surfaces(folder: &Path) {
    use sinew_mesh::{TruncatedEllipsoid, extract_surface};
    let mesh = TruncatedEllipsoid::LAND.wall([1, 32, 16]).tetrahedra();
    for name in ["endo", "epi"] {
        let surface = extract_surface(&mesh, &mesh.facet_sets[name]);
        let rows = |rows: Vec<String>| rows.join("\n");
        let points = surface.points.iter().map(|[x, y, z]| format!("{x:?} {y:?} {z:?}"));
        let cells = surface.cells.iter().map(|[a, b, c]| format!("3 {a} {b} {c}"));
        let file = format!(
            "# vtk DataFile Version 4.2\n{name}\nASCII\nDATASET POLYDATA\nPOINTS {} double\n{}\nPOLYGONS {} {}\n{}\n",
            surface.points.len(),
            rows(points.collect()),
            surface.cells.len(),
            4 * surface.cells.len(),
            rows(cells.collect())
        );
        std::fs::write(folder.join(format!("{name}.vtk")), file).unwrap();
    }
}

#[test]
fn surfaces_become_a_ventricle_that_solves() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    surfaces(folder);
    let meshed =
        done(folder, "mesh ventricle --endocardium endo.vtk --epicardium epi.vtk --nodes 300");
    assert!(meshed.contains("written: wall.vtu") && meshed.contains("volume ratio"), "{meshed}");
    let solved = done(
        folder,
        "solve LeftVentricle --mesh wall.vtu --theta a=0.18,b=2.6,a_f=3.3,b_f=2.7,p=8mmHg",
    );
    assert!(solved.contains("volume of region:1"), "{solved}");
    // The same with the sets' own names and the rule instead of the field.
    let page = include_str!("../../../../docs/case-file.md");
    let blocks = page.split("```toml\n").map(|block| block.split("```").next().unwrap());
    let case = blocks.skip(1).find(|block| block.contains("wall.vtu")).unwrap();
    assert!(case.trim().lines().count() <= 25);
    // The built-in scene keeps the thesis' linear cells.
    let case = case.replace("formulation = \"auto\"\n", "");
    std::fs::write(folder.join("heart.toml"), case).unwrap();
    let again = done(folder, "solve heart.toml --theta a=0.18,b=2.6,a_f=3.3,b_f=2.7,p=8mmHg");
    let displacement = |text: &str| {
        text.split(": displacement ")
            .nth(1)
            .and_then(|rest| rest.split(", volume").next())
            .unwrap()
            .to_string()
    };
    assert_eq!(displacement(&solved), displacement(&again));

    let meshed = done(
        folder,
        "mesh ventricle --endocardium endo.vtk --epicardium epi.vtk --nodes 300 --element hexahedra --trim 0.8 -o hexa.vtu",
    );
    let (mesh, _) = sinew_mesh::read_mesh::<8>(folder.join("hexa.vtu")).unwrap();
    let label = format!("{} hexahedra; the quality below is", mesh.cells.len());
    assert!(meshed.starts_with(&label), "{meshed}");
    assert_eq!(mesh.point_fields["fibre"].rows(), mesh.points.len());

    let ask = |more: &str| refused(folder, &format!("mesh ventricle --epicardium epi.vtk {more}"));
    let (code, told) = ask("--endocardium none.vtk");
    assert!(code == 2 && told.contains("none.vtk"), "{told}");
    let (code, told) = ask("--endocardium endo.vtk --trim 1,2");
    assert!(code == 2 && told.contains("x,y,z,nx,ny,nz"), "{told}");
    let (code, told) = ask("--endocardium endo.vtk --edge -1");
    assert!(code == 2 && told.contains("edges cannot be -1"), "{told}");
    let (code, told) = ask("--endocardium epi.vtk");
    assert!(code == 2 && told.contains("are the same surface"), "{told}");
}

#[test]
fn an_image_is_unloaded_and_loaded_again_from_files() {
    let folder = bar();
    let folder = folder.path();
    let told = done(folder, "unload bar.toml --theta lambda=12,mu=10 -o rest.vtu");
    assert!(
        told.contains("displacement to the image") && !told.contains("warning: loaded"),
        "{told}"
    );
    let image = sinew::Case::read(&folder.join("bar.toml")).unwrap().body().unwrap();
    let rest = sinew::Case::read(&folder.join("rest.toml")).unwrap().body().unwrap();
    let mut solver = sinew::Solver::new(&rest).unwrap();
    let loaded = solver.solve(&[10.0, 12.0], &sinew::Options::default()).unwrap();
    for (i, x) in image.positions.as_flattened().iter().enumerate() {
        let apart = rest.positions.as_flattened()[i] + loaded.displacement[i] - x;
        assert!(apart.abs() < 1e-9, "{apart}");
    }
    // Two bodies at rest of one case have folders of their own.
    done(folder, "unload bar.toml --theta lambda=12,mu=12 -o stiff.vtu");
    for name in ["rest", "stiff"] {
        done(folder, &format!("solve {name}.toml --theta lambda=12,mu=12"));
        assert!(folder.join("out").join(name).exists(), "{name}");
    }
    let (code, text) = refused(folder, "unload bar.toml -o rest.vtk");
    assert!(code == 2 && text.contains(".vtu"), "{text}");
    // Its own files are replaced.
    done(folder, "unload bar.toml --theta lambda=12,mu=11 -o rest.vtu");
}

#[test]
fn an_unloading_replaces_neither_its_image_nor_files_of_others() {
    let folder = bar();
    let folder = folder.path();
    let image = sinew_mesh::box_tetrahedra([30.0, 6.0, 6.0], [6, 2, 2]);
    sinew_mesh::write_vtu(folder.join("image.vtu"), &image).unwrap();
    std::fs::write(folder.join("notes.toml"), "mine = true\n").unwrap();
    let text = BAR
        .replace("box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }", "file = \"image.vtu\"");
    std::fs::write(folder.join("heart.toml"), text).unwrap();
    sinew_mesh::write_vtu(folder.join("other.vtu"), &image).unwrap();
    let kept = ["bar.toml", "heart.toml", "image.vtu", "notes.toml"];
    let read = || kept.map(|name| std::fs::read(folder.join(name)).unwrap());
    let before = read();
    for (line, words) in [
        ("unload bar.toml -o bar.vtu", "bar.toml is an input"),
        ("unload heart.toml -o ./image.vtu", "image.vtu is an input"),
        ("unload bar.toml --mesh image.vtu -o image.vtu", "image.vtu is an input"),
        ("unload heart.toml --mesh other.vtu -o image.vtu", "image.vtu is an input"),
        ("unload bar.toml -o notes.vtu", "notes.toml is there already"),
    ] {
        let (code, told) = refused(folder, line);
        assert!(code == 2 && told.contains(words), "{line}: {told}");
    }
    assert_eq!(read(), before);
}

#[test]
fn fibres_that_a_case_at_rest_cannot_name_are_told_without_load_too() {
    let folder = tempfile::tempdir().unwrap();
    let hexahedra = r#"
        law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
        loads = [{ pressure = "p", facets = "endo" }]
        supports = [{ clamped = "base" }]
        mesh = { element = "hexahedra", ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [2, 8, 4] } }
        fibres.rule = { endocardium = "endo", epicardium = "epi", base = "base", angles = [60.0, -60.0] }
        parameters = { a = 1.0, b = 2.0, a_f = 2.0, b_f = 2.0, p = { range = [0.0, 10.0], unit = "mmHg", sampling = "linear" } }
    "#;
    std::fs::write(folder.path().join("heart.toml"), hexahedra).unwrap();
    for p in ["p=0", "p=4"] {
        let (code, told) = refused(folder.path(), &format!("unload heart.toml --theta {p}"));
        assert!(code == 1 && told.contains("directions that differ within a cell"), "{p}: {told}");
    }
}
