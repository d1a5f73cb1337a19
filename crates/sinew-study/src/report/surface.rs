//! Deformed surfaces with a nodal error, reduced to the nodes that are seen.

use serde::{Deserialize, Serialize};

use super::error::check_number;
use super::{Method, ReportError};

/// One deformed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceCase {
    /// Which test case this is, e.g. `median case, μ = 61 kPa, λ = 88 kPa`.
    pub title: String,
    /// Whose prediction it is.
    pub method: Method,
    /// Deformed position per surface node \[mm\].
    pub deformed: Vec<[f32; 3]>,
    /// ‖u − û‖₂ per surface node \[mm\].
    pub err_u_mm: Vec<f32>,
}

/// A surface mesh and the cases drawn on it.
///
/// Keeps the surface nodes only; indices are checked when it is made or read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedCases")]
pub struct SurfaceCases {
    nodes: Vec<usize>,
    triangles: Vec<[usize; 3]>,
    reference: Vec<[f32; 3]>,
    cases: Vec<SurfaceCase>,
}

#[derive(Deserialize)]
struct UncheckedCases {
    nodes: Vec<usize>,
    triangles: Vec<[usize; 3]>,
    reference: Vec<[f32; 3]>,
    cases: Vec<SurfaceCase>,
}

impl TryFrom<UncheckedCases> for SurfaceCases {
    type Error = ReportError;

    fn try_from(read: UncheckedCases) -> Result<Self, ReportError> {
        check_triangles(&read.triangles, read.reference.len())?;
        check_length("nodes", read.nodes.len(), read.reference.len())?;
        for case in &read.cases {
            check_length("deformed", case.deformed.len(), read.reference.len())?;
            check_length("err_u_mm", case.err_u_mm.len(), read.reference.len())?;
        }
        Ok(Self {
            nodes: read.nodes,
            triangles: read.triangles,
            reference: read.reference,
            cases: read.cases,
        })
    }
}

impl SurfaceCases {
    /// The surface of a mesh: `triangles` name rows of `points`, the undeformed
    /// positions of all mesh nodes \[mm\].
    ///
    /// # Errors
    /// [`ReportError::TriangleNode`] if a triangle names a node that does not exist.
    pub fn new(triangles: &[[usize; 3]], points: &[[f64; 3]]) -> Result<Self, ReportError> {
        check_triangles(triangles, points.len())?;
        let mut nodes: Vec<usize> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut rank = vec![0; points.len()];
        for (compact, &node) in nodes.iter().enumerate() {
            rank[node] = compact;
        }
        Ok(Self {
            triangles: triangles.iter().map(|t| t.map(|node| rank[node])).collect(),
            reference: nodes.iter().map(|&node| single(points[node])).collect(),
            nodes,
            cases: Vec::new(),
        })
    }

    /// Adds a case: deformed positions and error of all mesh nodes \[mm\], of which the
    /// surface nodes are kept.
    ///
    /// # Errors
    /// [`ReportError::Length`] if a list does not cover all surface nodes or the two
    /// differ in length; [`ReportError::Number`] if a number is not finite.
    pub fn push(
        &mut self,
        method: Method,
        title: impl Into<String>,
        deformed: &[[f64; 3]],
        err_u_mm: &[f64],
    ) -> Result<(), ReportError> {
        let needed = self.nodes.last().map_or(0, |last| last + 1);
        check_length("deformed", deformed.len(), needed.max(deformed.len()))?;
        check_length("err_u_mm", err_u_mm.len(), deformed.len())?;
        for &node in &self.nodes {
            let [x, y, z] = deformed[node].map(f64::abs);
            check_number(|| format!("deformed position of node {node}"), x + y + z)?;
            check_number(|| format!("err_u_mm of node {node}"), err_u_mm[node])?;
        }
        self.cases.push(SurfaceCase {
            title: title.into(),
            method,
            deformed: self.nodes.iter().map(|&n| single(deformed[n])).collect(),
            err_u_mm: self.nodes.iter().map(|&n| err_u_mm[n] as f32).collect(),
        });
        Ok(())
    }

    /// Mesh node of every surface node.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Triangles over the surface nodes.
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// Undeformed position per surface node \[mm\].
    pub fn reference(&self) -> &[[f32; 3]] {
        &self.reference
    }

    /// The cases in the order they were added.
    pub fn cases(&self) -> &[SurfaceCase] {
        &self.cases
    }
}

fn single(point: [f64; 3]) -> [f32; 3] {
    point.map(|x| x as f32)
}

fn check_triangles(triangles: &[[usize; 3]], nodes: usize) -> Result<(), ReportError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&node) = corners.iter().find(|&&node| node >= nodes) {
            return Err(ReportError::TriangleNode { triangle, node, nodes });
        }
    }
    Ok(())
}

fn check_length(what: &str, found: usize, expected: usize) -> Result<(), ReportError> {
    if found == expected {
        return Ok(());
    }
    Err(ReportError::Length { what: what.to_owned(), found, expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 3]; 5] = [[0.0; 3], [9.0; 3], [1.0, 0.0, 0.0], [9.0; 3], [0.0, 1.0, 0.0]];

    #[test]
    fn keeps_surface_nodes_only() {
        let mut cases = SurfaceCases::new(&[[4, 0, 2]], &POINTS).unwrap();
        let error = [0.1, 0.2, 0.3, 0.4, 0.5];
        cases.push(Method::Pi, "median", &POINTS, &error).unwrap();
        assert_eq!(cases.nodes(), [0, 2, 4]);
        assert_eq!(cases.triangles(), [[2, 0, 1]]);
        assert_eq!(cases.cases()[0].err_u_mm, [0.1, 0.3, 0.5]);
    }

    #[test]
    fn refuses_lists_that_do_not_fit() {
        assert!(SurfaceCases::new(&[[0, 1, 5]], &POINTS).is_err());
        let mut cases = SurfaceCases::new(&[[4, 0, 2]], &POINTS).unwrap();
        let short = cases.push(Method::Pi, "short", &POINTS[..4], &[0.0; 4]);
        assert!(matches!(short, Err(ReportError::Length { found: 4, expected: 5, .. })));
        assert!(cases.push(Method::Pi, "odd", &POINTS, &[0.0; 4]).is_err());
        assert!(cases.push(Method::Pi, "nan", &POINTS, &[f64::NAN; 5]).is_err());
    }

    #[test]
    fn a_hostile_file_cannot_name_missing_nodes() {
        let text = r#"{"nodes":[0],"triangles":[[0,0,7]],"reference":[[0,0,0]],"cases":[]}"#;
        let message = serde_json::from_str::<SurfaceCases>(text).unwrap_err().to_string();
        assert!(message.contains("names node 7"), "{message}");
    }
}
