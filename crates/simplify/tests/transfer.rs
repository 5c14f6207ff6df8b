//! The positions of the corners of a result on the original.
#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec3};
use mesh_core::SplitMix64;
use mesh_core::{HalfEdgeId, TriMesh, VertexId};
use simplify::{
    AttributeOptions, CornerAttributes, Options, Preset, Rejection, corner_sources, seam_nodes,
    simplify,
};

/// The row of the grid along which the seam runs.
const SEAM: u32 = 15;

/// A flat grid whose inner vertices are displaced, except one row.
fn uneven_grid(cells: u32) -> TriMesh {
    let mut random = SplitMix64::new(7);
    let mut positions = Vec::new();
    for i in 0..=cells {
        for j in 0..=cells {
            let inner = |k: u32| f64::from(u8::from(k > 0 && k < cells));
            let mut shift = |k: u32| 0.3 * inner(k) * (random.uniform() - 0.5);
            let (x, y) = (shift(i) * f64::from(u8::from(i != SEAM)), shift(j));
            let place = DVec3::new(f64::from(i) + x, f64::from(j) + y, 0.0);
            positions.push(place / f64::from(cells));
        }
    }
    let at = |i: u32, j: u32| i * (cells + 1) + j;
    let cells = (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriMesh::from_triangles(&positions, &triangles).unwrap()
}

/// Data that is linear over a flat mesh is reproduced at every corner. Here the data is the position.
#[test]
fn linear_data_is_reproduced() {
    let mesh = uneven_grid(30);
    let topology = mesh.topology();
    let middle = |v: VertexId| v.index() >= (31 * SEAM) as usize;
    let mut seams = topology.edge_map(false);
    for e in topology.edges().filter(|&e| !topology.is_boundary_edge(e)) {
        let faces = topology.edge_faces(e).into_iter().flatten();
        let sides: Vec<bool> =
            faces.map(|f| topology.face_vertices(f).into_iter().all(middle)).collect();
        seams[e] = sides[0] != sides[1];
    }
    let place = |h: HalfEdgeId| mesh.position(topology.origin(h)).to_array();
    for preset in [Preset::Fast, Preset::Default, Preset::Extreme] {
        let mut options = Options::preset(preset).to_faces(60);
        options.protect.features = Some(seams.clone());
        options.protect.locked = Some(seam_nodes(topology, &seams));
        options.attributes.corners = Some(CornerAttributes::new(&mesh, true, place).unwrap());
        let result = simplify(&mesh, &options).unwrap();
        let sources = corner_sources(&mesh, &seams, None, &result.mesh, &result.vertex_map);
        let new = result.mesh.topology();
        assert!(new.face_count() <= 60);
        for face in new.faces() {
            let mut sides = Vec::new();
            for h in new.face_half_edges(face) {
                let source = sources[h].unwrap();
                let corners = mesh.triangle(source.face);
                let found: DVec3 =
                    corners.into_iter().zip(source.weights).map(|(p, w)| p * w).sum();
                let at = result.mesh.position(new.origin(h));
                assert!(found.distance(at) < 1e-9, "{preset}: {found} at {at}");
                sides.push(topology.face_vertices(source.face).into_iter().all(middle));
            }
            assert!(sides.iter().all(|&side| side == sides[0]), "{preset}: a face over the seam");
        }
    }
}

/// The geometry of a flat mesh does not protect its texture, which folds over when faces become longer than its waves.
/// Collapses that fold it over are rejected. With a texture weight no face is folded at the end; if the cost hardly
/// counts it, fewer faces are.
#[test]
fn faces_do_not_turn_over_in_the_texture() {
    let mesh = uneven_grid(30);
    let topology = mesh.topology();
    let texture = |p: DVec3| [p.x, p.y + 0.2 * (30.0 * p.x).sin()];
    let turned_and_refused = |has_texture: bool, weight: f64| {
        let mut options = Options::preset(Preset::Fast).to_faces(120);
        let of_corner = |h: HalfEdgeId| texture(mesh.position(topology.origin(h)));
        let corners = CornerAttributes::new(&mesh, has_texture, of_corner).unwrap();
        options.attributes = AttributeOptions { corners: Some(corners), weight, poses: None };
        let result = simplify(&mesh, &options).unwrap();
        let no_seam = topology.edge_map(false);
        let sources = corner_sources(&mesh, &no_seam, None, &result.mesh, &result.vertex_map);
        let turns = |face| {
            let [a, b, c] = result.mesh.topology().face_half_edges(face).map(|h| {
                let source = sources[h].unwrap();
                let corners = mesh.triangle(source.face).map(|p| DVec2::from(texture(p)));
                corners.into_iter().zip(source.weights).map(|(uv, w)| uv * w).sum::<DVec2>()
            });
            (b - a).perp_dot(c - a) < 0.0
        };
        let turned = result.mesh.topology().faces().filter(|&face| turns(face)).count();
        (turned, result.rejections.of(Rejection::TextureFold))
    };
    assert_eq!(turned_and_refused(true, 1.0).0, 0);
    let ((some, refused), (more, never)) =
        (turned_and_refused(true, 1e-9), turned_and_refused(false, 1e-9));
    assert!(some < more && refused > 10 && never == 0, "{some} {more} {refused} {never}");
}

/// On either side of a seam the texture is linear. It cannot fold over, and all positions are equally good.
#[test]
fn corners_at_a_seam_move_with_their_own_side() {
    let mesh = uneven_grid(30);
    let topology = mesh.topology();
    let is_beyond = |v: VertexId| v.index() >= (31 * SEAM) as usize;
    let of_corner = |h: HalfEdgeId| {
        let p = mesh.position(topology.origin(h));
        let face = topology.face(h).unwrap();
        let shift = if topology.face_vertices(face).into_iter().all(is_beyond) { 5.0 } else { 0.0 };
        [p.x + shift, p.y]
    };
    let mut options = Options::preset(Preset::Fast).to_faces(60);
    let corners = CornerAttributes::new(&mesh, true, of_corner).unwrap();
    options.attributes = AttributeOptions { corners: Some(corners), ..AttributeOptions::default() };
    let result = simplify(&mesh, &options).unwrap();
    assert!(result.mesh.topology().face_count() <= 60);
    assert_eq!(result.rejections.of(Rejection::TextureFold), 0);
}
