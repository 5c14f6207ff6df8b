//! Random legal edits keep every invariant, the Euler characteristic and the boundary loops.
#![allow(clippy::unwrap_used, clippy::panic)]

use mesh_core::edit::{CollapseRefusal, FlipRefusal};
use mesh_core::{EdgeId, FaceId, HalfEdgeId, Topology, VertexId};
use proptest::prelude::*;

/// A torus of quads, each cut in two.
fn torus(m: u32, n: u32) -> Topology {
    let at = |i: u32, j: u32| (i % m) * n + j % n;
    let cells = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, d], [d, b, c]]
        })
        .collect();
    Topology::from_triangles((m * n) as usize, &triangles).unwrap()
}

/// A grid of quads with a square hole in the middle, each quad cut in two.
fn grid_with_hole(n: u32) -> Topology {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let hole = n / 3..2 * n / 3;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .filter(|(i, j)| !(hole.contains(i) && hole.contains(j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Topology::from_triangles(((n + 1) * (n + 1)) as usize, &triangles).unwrap()
}

fn octahedron() -> Topology {
    let triangles =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    Topology::from_triangles(6, &triangles).unwrap()
}

fn tetrahedron() -> Topology {
    Topology::from_triangles(4, &[[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]).unwrap()
}

/// Two triangles that share an edge.
fn two_triangles() -> Topology {
    Topology::from_triangles(4, &[[0, 1, 2], [2, 1, 3]]).unwrap()
}

#[derive(Clone, Copy, Debug)]
enum Edit {
    Flip(usize),
    Collapse(usize),
    SplitEdge(usize),
    SplitFace(usize),
    Compact,
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let edit = prop_oneof![
        4 => any::<usize>().prop_map(Edit::Flip),
        4 => any::<usize>().prop_map(Edit::Collapse),
        1 => any::<usize>().prop_map(Edit::SplitEdge),
        1 => any::<usize>().prop_map(Edit::SplitFace),
        1 => Just(Edit::Compact),
    ];
    prop::collection::vec(edit, 1..200)
}

/// Applies an edit if it is legal; returns whether it was.
fn apply(topology: &mut Topology, edit: Edit) -> bool {
    match edit {
        Edit::Flip(i) => {
            let edge = EdgeId::new((i % topology.edge_capacity()) as u32);
            topology.check_flip(edge).map(|flip| topology.flip(flip)).is_ok()
        }
        Edit::Collapse(i) => {
            let h = HalfEdgeId::new((i % topology.half_edge_capacity()) as u32);
            topology.check_collapse(h).map(|c| topology.collapse(c)).is_ok()
        }
        Edit::SplitEdge(i) => {
            let edge = EdgeId::new((i % topology.edge_capacity()) as u32);
            topology.check_split_edge(edge).map(|s| topology.split_edge(s)).is_ok()
        }
        Edit::SplitFace(i) => {
            let face = FaceId::new((i % topology.face_capacity()) as u32);
            topology.check_split_face(face).map(|s| topology.split_face(s)).is_ok()
        }
        Edit::Compact => {
            topology.compact();
            topology.is_compact()
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_edits_keep_the_surface(edits in edits(), start in 0..5_usize) {
        let mut topology = [
            torus(5, 4), grid_with_hole(6), octahedron(), tetrahedron(), two_triangles(),
        ][start].clone();
        topology.validate().unwrap();
        let chi = topology.euler_characteristic();
        let loops = topology.boundary_loops().len();
        let components = topology.components().count;
        for edit in edits {
            let faces = topology.face_count();
            let changed = apply(&mut topology, edit);
            prop_assert!(changed || topology.face_count() == faces);
            if let Err(broken) = topology.validate() {
                panic!("{edit:?}: {broken}");
            }
            prop_assert_eq!(topology.euler_characteristic(), chi);
            prop_assert_eq!(topology.boundary_loops().len(), loops);
            prop_assert_eq!(topology.components().count, components);
        }
    }

    #[test]
    fn trap_15_flip_and_flip_back_restores_the_index_buffer(
        edits in edits(),
        start in 0..3_usize,
    ) {
        let mut topology = [torus(4, 4), grid_with_hole(5), octahedron()][start].clone();
        for edit in edits {
            apply(&mut topology, edit);
        }
        let before: Vec<[u32; 3]> = topology.triangles().collect();
        let edges: Vec<EdgeId> = topology.edges().collect();
        for edge in edges {
            let Ok(flip) = topology.check_flip(edge) else { continue };
            let [a, b, c, d] = flip.quad();
            topology.flip(flip);
            let ends = topology.edge_vertices(edge);
            prop_assert!(ends == [c, d] || ends == [d, c]);
            let back = topology.check_flip(edge).unwrap();
            topology.flip(back);
            prop_assert_eq!(topology.edge_vertices(edge), [a, b]);
            let after: Vec<[u32; 3]> = topology.triangles().collect();
            prop_assert_eq!(&before, &after);
        }
    }

    /// A collapse is allowed exactly when gluing the vertices in the face list leaves a mesh.
    #[test]
    fn collapse_checks_agree_with_gluing_by_hand(edits in edits(), start in 0..5_usize) {
        let mut topology = [
            torus(4, 3), grid_with_hole(3), octahedron(), tetrahedron(), two_triangles(),
        ][start].clone();
        for edit in edits.into_iter().take(30) {
            apply(&mut topology, edit);
        }
        topology.compact();
        for h in topology.half_edges().collect::<Vec<_>>() {
            let allowed = topology.check_collapse(h).is_ok();
            prop_assert_eq!(allowed, gluing_leaves_the_same_surface(&topology, h), "{:?}", h);
        }
    }
}

/// Replaces the origin of `h` by its target in the face list and rebuilds the mesh.
fn gluing_leaves_the_same_surface(topology: &Topology, h: HalfEdgeId) -> bool {
    let (gone, kept) = (topology.origin(h).get(), topology.target(h).get());
    let mut distinct = std::collections::BTreeSet::new();
    let glued: Vec<[u32; 3]> = topology
        .triangles()
        .map(|t| t.map(|v| if v == gone { kept } else { v }))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    let no_twins = glued.iter().all(|t| {
        let mut sorted = *t;
        sorted.sort_unstable();
        distinct.insert(sorted)
    });
    let edge_is_on_boundary = topology.is_boundary_edge(h.edge());
    let removed = topology.face_count() - glued.len();
    let Ok(result) = Topology::from_triangles(topology.vertex_capacity(), &glued) else {
        return false;
    };
    let isolated = |t: &Topology| t.vertices().filter(|&v| t.is_isolated_vertex(v)).count();
    no_twins
        && isolated(&result) == isolated(topology) + 1
        && removed == if edge_is_on_boundary { 1 } else { 2 }
        && result.components().count == topology.components().count
        && result.euler_characteristic() == topology.euler_characteristic()
        && result.boundary_loops().len() == topology.boundary_loops().len()
}

#[test]
fn refusals_name_the_reason() {
    let tetrahedron = tetrahedron();
    let h = HalfEdgeId::new(0);
    assert_eq!(tetrahedron.check_collapse(h).unwrap_err(), CollapseRefusal::Tetrahedron);
    assert_eq!(
        tetrahedron.check_flip(h.edge()).unwrap_err(),
        FlipRefusal::ValenceThree(tetrahedron.origin(h))
    );
    let pair = two_triangles();
    let inner = pair.edges().find(|&e| !pair.is_boundary_edge(e)).unwrap();
    assert_eq!(
        pair.check_collapse(inner.half_edge()).unwrap_err(),
        CollapseRefusal::JoinsBoundaries
    );
    let outer = pair.edges().find(|&e| pair.is_boundary_edge(e)).unwrap();
    assert_eq!(pair.check_flip(outer).unwrap_err(), FlipRefusal::Boundary(outer));
    let lone = Topology::from_triangles(3, &[[0, 1, 2]]).unwrap();
    assert_eq!(
        lone.check_collapse(HalfEdgeId::new(0)).unwrap_err(),
        CollapseRefusal::LastFace(FaceId::new(0))
    );
    let octahedron = octahedron();
    let outside = EdgeId::new(999);
    assert_eq!(octahedron.check_flip(outside).unwrap_err(), FlipRefusal::NotInMesh(outside));
}

#[test]
#[should_panic(expected = "edited after")]
fn a_stale_token_is_refused() {
    let mut topology = octahedron();
    let [first, second] = [0, 1].map(|e| topology.check_flip(EdgeId::new(e)).unwrap());
    topology.flip(first);
    topology.flip(second);
}

#[test]
fn an_edge_split_tells_what_it_made() {
    let mut topology = two_triangles();
    let inner = topology.edges().find(|&e| !topology.is_boundary_edge(e)).unwrap();
    let [a, b] = topology.edge_vertices(inner);
    let split = topology.check_split_edge(inner).unwrap();
    let made = topology.split_edge(split);
    topology.validate().unwrap();
    assert_eq!(topology.edge_vertices(inner), [a, made.vertex]);
    assert_eq!(topology.origin(made.half_edge), made.vertex);
    assert_eq!(topology.target(made.half_edge), b);
    assert_eq!(topology.face(made.half_edge), made.faces[0]);
    assert_eq!(topology.face(made.half_edge.twin()), made.faces[1]);
    assert_eq!(topology.valence(made.vertex), 4);
    let apexes = made.incident_edges.map(|s| topology.edge_vertices(s.unwrap())[1]);
    assert!(apexes.iter().all(|v| ![a, b, made.vertex].contains(v)));
}

#[test]
fn a_face_split_tells_what_it_made() {
    let mut topology = tetrahedron();
    let face = FaceId::new(1);
    let corners = topology.face_vertices(face);
    let split = topology.check_split_face(face).unwrap();
    let made = topology.split_face(split);
    topology.validate().unwrap();
    assert_eq!(topology.face_vertices(face), [corners[0], corners[1], made.vertex]);
    assert_eq!(
        made.incident_edges.map(|s| topology.edge_vertices(s)),
        corners.map(|c| [made.vertex, c])
    );
    assert_eq!(topology.valence(made.vertex), 3);
}

#[test]
fn compacting_keeps_order_and_attributes() {
    let mut topology = torus(5, 5);
    let mut name = topology.vertex_map(0);
    for (i, value) in name.as_mut_slice().iter_mut().enumerate() {
        *value = i;
    }
    let h = topology.find_half_edge(VertexId::new(7), VertexId::new(8)).unwrap();
    let collapse = topology.check_collapse(h).unwrap();
    let collapsed = topology.collapse(collapse);
    assert_eq!(collapsed.removed_vertex, VertexId::new(7));
    let remap = topology.compact();
    let kept = name.compact(&remap);
    assert!(kept.into_vec().into_iter().eq((0..25).filter(|&i| i != 7)));
    topology.validate().unwrap();
}
