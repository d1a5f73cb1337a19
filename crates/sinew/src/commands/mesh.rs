//! Meshes from surfaces.

use super::{Usage, check_vtu, keep, warn};
use anyhow::Result;
use clap::{Args, Subcommand};
use sinew::case::Element;
use sinew::ventricle;
use sinew_mesh::{Chamber, Size, TriangleMesh, Trim, WallOptions, read_mesh};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Kind of body that is meshed.
#[derive(Debug, Subcommand)]
pub(crate) enum Mesh {
    /// Mesh the wall of a ventricle between its surfaces, with facet sets, fibres and the distance to the surfaces.
    Ventricle(Ventricle),
}

/// Surfaces and sizes.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/ventricle.txt"))]
pub(crate) struct Ventricle {
    /// Inner surface
    #[arg(long, value_name = "FILE")]
    endocardium: PathBuf,
    /// Outer surface, of this ventricle or of the whole heart
    #[arg(long, value_name = "FILE")]
    epicardium: PathBuf,
    /// Endocardium of the other ventricle: its near side bounds the wall as well
    #[arg(long, value_name = "FILE")]
    septum: Option<PathBuf>,
    /// Approximate number of nodes [default: 1500]
    #[arg(long, value_name = "COUNT", conflicts_with = "edge")]
    nodes: Option<usize>,
    /// Length of edges, in the unit of the surfaces, instead of --nodes
    #[arg(long, value_name = "LENGTH")]
    edge: Option<f64>,
    /// Layers of cells through the wall [default: cells about as thick as wide, at least two layers]
    #[arg(long, value_name = "COUNT")]
    layers: Option<usize>,
    /// Base: auto (the highest plane below the valves that cuts a whole wall), a fraction of the way from the
    /// apex to the middle of the valves, or the plane x,y,z,nx,ny,nz by a point and a normal
    #[arg(long, value_name = "PLANE", default_value = "auto", allow_hyphen_values = true)]
    trim: String,
    /// Kind of cells
    #[arg(long, value_enum, default_value_t)]
    element: Element,
    /// Angles of the fibres to the circumference at the inner and outer surface [degrees]
    #[arg(long, value_name = "INNER,OUTER", default_value = "60,-60", allow_hyphen_values = true)]
    angles: String,
    /// Output: a VTU file
    #[arg(short, long, visible_alias = "out", value_name = "FILE", default_value = "wall.vtu")]
    output: PathBuf,
}

impl Mesh {
    pub(crate) fn run(&self) -> Result<()> {
        let Self::Ventricle(ventricle) = self;
        ventricle.run()
    }
}

impl Ventricle {
    fn run(&self) -> Result<()> {
        check_vtu(&self.output)?;
        keep([&self.endocardium, &self.epicardium].into_iter().chain(&self.septum), &self.output)?;
        let options = self.options()?;
        let angles = numbers::<2>(&self.angles).ok_or_else(|| {
            Usage(format!("--angles {}: give two angles, such as 60,-60", self.angles))
        })?;
        let endocardium = surface(&self.endocardium)?;
        let epicardium = surface(&self.epicardium)?;
        let septum = self.septum.as_deref().map(surface).transpose()?;
        let chamber =
            Chamber { endocardium: &endocardium, epicardium: &epicardium, septum: septum.as_ref() };
        let start = Instant::now();
        let wall = chamber.wall(&options).map_err(|error| {
            let [inner, outer] = [&self.endocardium, &self.epicardium].map(|file| file.display());
            Usage(format!("no wall between {inner} and {outer}: {error}"))
        })?;
        let seconds = start.elapsed().as_secs_f64();
        let mesh = ventricle(&wall, self.element == Element::Hexahedra, angles)
            .map_err(|error| anyhow::anyhow!("the wall cannot be meshed: {error}"))?;
        if self.element == Element::Hexahedra {
            println!(
                "{} hexahedra; the quality below is that of the same wall as tetrahedra",
                mesh.cell_count()
            );
        }
        println!("{}", wall.report());
        println!("fitted in {seconds:.2} s");
        mesh.write_vtu(&self.output)?;
        println!("written: {}", self.output.display());
        warn(wall.report().warnings());
        Ok(())
    }

    fn options(&self) -> Result<WallOptions> {
        let size = match (self.edge, self.nodes) {
            (Some(edge), _) => Size::Edge(edge),
            (None, nodes) => Size::Nodes(nodes.unwrap_or(1500)),
        };
        let trim = match self.trim.as_str() {
            "auto" => Some(Trim::Auto),
            text => numbers(text).map(|[part]| Trim::Fraction(part)).or_else(|| {
                numbers(text)
                    .map(|[x, y, z, a, b, c]| Trim::Plane { point: [x, y, z], normal: [a, b, c] })
            }),
        };
        let trim = trim.ok_or_else(|| {
            Usage(format!(
                "--trim {}: give auto, a fraction of the axis such as 0.8, or six numbers x,y,z,nx,ny,nz",
                self.trim
            ))
        })?;
        Ok(WallOptions { size, layers: self.layers, trim })
    }
}

fn surface(path: &Path) -> Result<TriangleMesh> {
    let (surface, report) = read_mesh::<3>(path).map_err(|error| Usage(error.to_string()))?;
    // Nodes at one place do no harm here.
    report.changes().iter().for_each(|change| eprintln!("{}: {change}", path.display()));
    Ok(surface)
}

/// N numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}
