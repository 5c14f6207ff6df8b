//! Sequences of edits, each checked before and validated after.

use arbitrary::{Result, Unstructured};
use mesh_core::{EdgeId, FaceTree, TriMesh};

use crate::shape::{assert_sound, mesh, point};

/// Flips, collapses, splits and compactions in any order.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let mut mesh = mesh(u)?;
    assert_sound(&mesh);
    let mut tree = FaceTree::new(&mesh);
    while !u.is_empty() {
        let counts = Counts::of(&mesh);
        let is_compacted = edit(u, &mut mesh, &mut tree)?;
        mesh.topology().validate().expect("an edit keeps the invariants");
        if is_compacted {
            tree = FaceTree::new(&mesh);
        }
        assert_eq!(Counts::of(&mesh).euler, counts.euler, "an edit is no surgery");
    }
    for face in mesh.topology().faces() {
        let bounds = mesh
            .triangle(face)
            .iter()
            .fold((glam::DVec3::MAX, glam::DVec3::MIN), |b, &p| (b.0.min(p), b.1.max(p)));
        let bounds = mesh_core::BoundingBox { min: bounds.0, max: bounds.1 };
        assert_eq!(tree.find(&mesh, bounds, |f| f == face), Some(face), "the tree has lost a face");
    }
    Ok(())
}

struct Counts {
    euler: i64,
}

impl Counts {
    /// Vertices without edges, which collapses may leave behind, do not count.
    fn of(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).count();
        let euler = used as i64 - topology.edge_count() as i64 + topology.face_count() as i64;
        Self { euler }
    }
}

/// One edit, if it is allowed; returns whether handles have changed.
fn edit(u: &mut Unstructured<'_>, mesh: &mut TriMesh, tree: &mut FaceTree) -> Result<bool> {
    let topology = mesh.topology();
    let operation = u.int_in_range(0..=8)?;
    if operation == 8 {
        mesh.compact();
        return Ok(true);
    }
    let edges: Vec<EdgeId> = topology.edges().collect();
    if edges.is_empty() {
        return Ok(false);
    }
    let edge = *u.choose(&edges)?;
    match operation {
        0..=2 => {
            if let Ok(flip) = topology.check_flip(edge) {
                let before = topology.edge_vertices(edge);
                mesh.flip(flip);
                assert_ne!(mesh.topology().edge_vertices(edge), before);
                tree.update(mesh, mesh.topology().edge_faces(edge).into_iter().flatten());
            }
        }
        3..=5 => {
            let half_edge = edge.half_edges()[usize::from(u.arbitrary::<bool>()?)];
            if let Ok(collapse) = topology.check_collapse(half_edge) {
                let kept = collapse.kept();
                let (removed, place) = (collapse.removed(), point(u)?);
                let collapsed = mesh.collapse(collapse, place);
                assert_eq!([collapsed.removed_vertex, collapsed.kept_vertex], [removed, kept]);
                assert!(!mesh.topology().contains_vertex(removed));
                assert_eq!(mesh.position(kept), place);
                let around = mesh.topology().outgoing(kept);
                let faces: Vec<_> = around.filter_map(|h| mesh.topology().face(h)).collect();
                tree.update(mesh, faces);
                tree.update(mesh, collapsed.removed_faces.into_iter().flatten());
            }
        }
        6 => {
            if let Ok(split) = topology.check_split_edge(edge) {
                let place = point(u)?;
                let done = mesh.split_edge(split, place);
                assert_eq!(mesh.position(done.vertex), place);
                let around = mesh.topology().outgoing(done.vertex);
                let faces: Vec<_> = around.filter_map(|h| mesh.topology().face(h)).collect();
                tree.update(mesh, faces);
            }
        }
        _ => {
            let Some(face) = topology.edge_faces(edge).into_iter().flatten().next() else {
                return Ok(false);
            };
            if let Ok(split) = topology.check_split_face(face) {
                let place = point(u)?;
                let done = mesh.split_face(split, place);
                assert_eq!(mesh.topology().valence(done.vertex), 3);
                assert!(done.vertex.index() < mesh.topology().vertex_capacity());
                tree.update(mesh, done.faces.into_iter().chain([face]));
            }
        }
    }
    Ok(false)
}
