//! Refinement of a region of a result that does not fit into memory, against its own part of the original.
//!
//! The boundary of its own faces stays unchanged. So regions can be refined one by one, on any machine, and still fit
//! together.

use mesh_core::{FaceId, Repair, TriMesh, VertexId, as_u32, build};
use simplify::Steps;

use crate::error::Error;
use crate::non_manifold::non_manifold_vertices;
use crate::refine::{Refined, Refinement, only_moves, used_vertices};
use crate::region::Region;
use crate::renumber::NONE;
use crate::step::Step;
use crate::work::Work;

/// Refines the own faces of a region; copies of other faces are left out.
pub(crate) fn refine_region(
    work: &Work,
    region: Region,
    options: &Steps,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<Region, Error> {
    let (mesh, source) = own_mesh(&region)?;
    let bits = work.cells(0)?.trailing_zeros() - work.cells(region.level)?.trailing_zeros();
    let cells = (region.cell << bits)..((region.cell + 1) << bits);
    let refine = |options: &Steps, observer: &mut dyn FnMut(Step) -> bool| {
        Refinement { work, cells: cells.clone(), options }.refine(mesh.clone(), observer)
    };
    let mut refined = refine(options, observer)?;
    // A neighbour may have flipped to the same edge.
    if has_new_edges(&mesh, &refined) {
        refined = refine(&only_moves(options), observer)?;
    }
    Ok(put_back(region, &mesh, &source, &refined))
}

/// The own faces of a region as a mesh, and the index in the region of each vertex.
fn own_mesh(region: &Region) -> Result<(TriMesh, Vec<u32>), Error> {
    let position = |v: u32| region.positions[v as usize];
    let (soup, source) = used_vertices(region.own_triangles(), region.positions.len(), position)?;
    // Faces that share only a vertex are separated there. The vertex is on the boundary, and does not move.
    let mut cut = Repair::strict();
    cut.cut_non_manifold = true;
    let built = build(&soup, &cut).map_err(|error| Error::Build(Box::new(error)))?;
    let source = built.provenance.vertex_source.iter().map(|&v| source[v as usize]).collect();
    Ok((built.mesh, source))
}

/// Whether there is a new edge between two vertices of the boundary.
fn has_new_edges(before: &TriMesh, refined: &Refined) -> bool {
    let topology = before.topology();
    let mut old = vec![NONE; refined.mesh.positions().len()];
    for v in topology.vertices().filter(|&v| topology.is_boundary_vertex(v)) {
        let new = refined.kept[v.index()];
        if new != NONE {
            old[new as usize] = v.get();
        }
    }
    let after = refined.mesh.topology();
    after.edges().any(|edge| {
        let [a, b] = after.edge_vertices(edge).map(|v| old[v.index()]);
        let found = |a, b| topology.find_half_edge(VertexId::new(a), VertexId::new(b)).is_some();
        a != NONE && b != NONE && !found(a, b) && !found(b, a)
    })
}

/// The region with its refined faces. Vertices on their boundary keep their indices in the input; vertices inside get
/// free indices.
fn put_back(region: Region, before: &TriMesh, source: &[u32], refined: &Refined) -> Region {
    let Region { level, cell, own, vertex_ids, other_cells, positions, .. } = region;
    let mesh = &refined.mesh;
    let topology = before.topology();
    // For each vertex of the result, its index in the region.
    let mut place = vec![NONE; mesh.positions().len()];
    let mut is_used = vec![false; positions.len()];
    let mut is_within = vec![false; positions.len()];
    for v in topology.vertices() {
        let (old, new) = (source[v.index()], refined.kept[v.index()]);
        if topology.is_boundary_vertex(v) && new != NONE {
            place[new as usize] = old;
            is_used[old as usize] = true;
        } else {
            is_within[old as usize] = true;
        }
    }
    let mut free = (0..own).filter(|&v| is_within[v] && !is_used[v]).map(|v| vertex_ids[v]);
    let mut beyond = (0..u64::MAX).rev();
    // Own vertices: first those on the boundary and those that only copies use, then those inside.
    let mut owned: Vec<(u64, u32, bool)> = (0..as_u32(own))
        .filter(|&v| is_used[v as usize] || !is_within[v as usize])
        .map(|v| (vertex_ids[v as usize], v, true))
        .collect();
    for (new, _) in place.iter().enumerate().filter(|(_, place)| **place == NONE) {
        let id = free.next().or_else(|| beyond.next()).unwrap_or_default();
        owned.push((id, as_u32(new), false));
    }
    owned.sort_unstable();
    let others: Vec<u32> =
        (as_u32(own)..as_u32(positions.len())).filter(|&v| is_used[v as usize]).collect();
    let mut number_of_old = vec![NONE; positions.len()];
    let mut number = vec![NONE; mesh.positions().len()];
    let mut result = Region { level, cell, own: owned.len(), ..Region::default() };
    for (i, &(id, v, is_old)) in (0..).zip(&owned) {
        result.vertex_ids.push(id);
        if is_old {
            number_of_old[v as usize] = i;
            result.positions.push(positions[v as usize]);
        } else {
            number[v as usize] = i;
            result.positions.push(mesh.positions()[v as usize]);
        }
    }
    for (i, &v) in (as_u32(owned.len())..).zip(&others) {
        number_of_old[v as usize] = i;
        result.vertex_ids.push(vertex_ids[v as usize]);
        result.other_cells.push(other_cells[v as usize - own]);
        result.positions.push(positions[v as usize]);
    }
    for (new, &old) in place.iter().enumerate().filter(|(_, old)| **old != NONE) {
        number[new] = number_of_old[old as usize];
    }
    let faces = mesh.topology().faces();
    let triangle = |face: FaceId| mesh.topology().face_vertices(face).map(|v| number[v.index()]);
    result.triangles = faces.map(triangle).collect();
    result.non_manifold = non_manifold_vertices(result.own, &result.triangles);
    result
}
