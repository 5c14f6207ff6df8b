//! Whether a written file is watertight, judged by reading it again.

use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use mesh_core::build::weld_exact;
use mesh_core::fill::FillReport;
use mesh_core::{HalfEdgeId, PolygonSoup, VertexId, diagnose};
use mesh_io::{Format, ReadOptions};
use mesh_work::{Loaded, splits_vertices};
use serde::Serialize;

use crate::counted::counted;
use crate::failure::Failure;

/// Holes listed one by one; further ones are only counted.
const LISTED: usize = 8;

/// A written file as a reader sees it. Vertices at equal positions are joined in formats that split vertices: STL,
/// glTF, and OBJ with texture coordinates or normals.
#[derive(Serialize)]
pub(crate) struct Written {
    /// Every edge has exactly two faces, with opposite directions.
    pub(crate) watertight: bool,
    boundary_edges: usize,
    boundary_loops: usize,
    non_manifold_edges: usize,
    inconsistent_edges: usize,
    inside_out: Option<usize>,
    /// The first holes of the repaired mesh, and why they are open.
    holes: Vec<Hole>,
}

/// An open boundary loop.
#[derive(Serialize)]
pub(crate) struct Hole {
    edges: usize,
    /// One of its vertices.
    at: [f64; 3],
    why: String,
}

impl Written {
    /// Reads a file that was just written and evaluates it.
    pub(crate) fn judge(
        path: &Path,
        format: Option<Format>,
        holes: Vec<Hole>,
    ) -> Result<Self, Failure> {
        let options = ReadOptions { format, allow_empty: true, ..ReadOptions::default() };
        let model =
            mesh_io::read_with(path, &options).map_err(|error| Failure::Read(Box::new(error)))?;
        let is_split = format == Some(Format::Stl) || splits_vertices(&model, format);
        let soup = if is_split { welded(&model.soup) } else { model.soup };
        let failed = |source| Failure::Build {
            path: path.to_owned(),
            source: Box::new(source),
            joined: is_split,
        };
        let found = diagnose(&soup).map_err(failed)?;
        let is_manifold = found.non_manifold_edges == 0 && found.inconsistent_edges == 0;
        Ok(Self {
            watertight: found.is_closed() && is_manifold,
            boundary_edges: found.boundary_edges,
            boundary_loops: found.boundary_loops,
            non_manifold_edges: found.non_manifold_edges,
            inconsistent_edges: found.inconsistent_edges,
            inside_out: found.inside_out,
            holes,
        })
    }
}

fn welded(soup: &PolygonSoup) -> PolygonSoup {
    soup.merged(&weld_exact(soup.positions()))
}

/// The open boundary loops of a repaired mesh, the longest first, and why each is open.
pub(crate) fn holes_of(loaded: &Loaded, filled: Option<&FillReport>) -> Vec<Hole> {
    let topology = loaded.mesh.topology();
    let source = |v: VertexId| loaded.provenance.vertex_source[v.index()];
    let mut copies: HashMap<u32, usize> = HashMap::new();
    for v in topology.vertices() {
        *copies.entry(source(v)).or_default() += 1;
    }
    let is_copy = |v: VertexId| copies.get(&source(v)).is_some_and(|&count| count > 1);
    let is_cut = |h: HalfEdgeId| is_copy(topology.origin(h)) && is_copy(topology.target(h));
    let mut holes: Vec<Hole> = topology
        .boundary_loops()
        .into_iter()
        .map(|first| {
            let refusal = filled
                .and_then(|report| report.left.iter().find(|(at, _)| *at == first))
                .map(|(_, why)| why.to_string());
            let why = if topology.boundary_loop(first).any(is_cut) {
                "the surface was cut along an edge of more than two faces".to_owned()
            } else {
                refusal.unwrap_or_else(|| "not filled: give --fill-holes".to_owned())
            };
            Hole {
                edges: topology.boundary_loop(first).count(),
                at: loaded.mesh.position(topology.origin(first)).to_array(),
                why,
            }
        })
        .collect();
    holes.sort_by_key(|hole| core::cmp::Reverse(hole.edges));
    holes.truncate(LISTED);
    holes
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.watertight {
            f.write_str("\n  watertight: yes")?;
        } else {
            let counts = [
                (self.boundary_edges, "open edges"),
                (self.non_manifold_edges, "edges of more than two faces"),
                (self.inconsistent_edges, "edges whose faces have opposite orientations"),
            ];
            let counts = counts.iter().filter(|(count, _)| *count > 0);
            let counts: Vec<String> = counts.map(|&(count, what)| counted(count, what)).collect();
            let counts = if counts.is_empty() { "no faces".to_owned() } else { counts.join(", ") };
            write!(f, "\n  watertight: no ({counts})")?;
        }
        for Hole { edges, at: [x, y, z], why } in &self.holes {
            let edges = counted(*edges, "edges");
            write!(f, "\n  hole of {edges} at ({x}, {y}, {z}): {why}")?;
        }
        if self.boundary_loops > self.holes.len() && self.holes.len() == LISTED {
            write!(f, "\n  ... {} more holes", self.boundary_loops - LISTED)?;
        }
        Ok(())
    }
}
