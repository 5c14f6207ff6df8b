//! Building the half-edge structure, circulating in it, and refusing triangles that do not form a surface.
#![allow(clippy::unwrap_used)]

use mesh_core::{FaceId, HalfEdgeId, PolygonSoup, Topology, TopologyError, TriMesh, VertexId};

#[test]
fn a_fan_is_walked_clockwise_from_its_boundary() {
    let fan = Topology::from_triangles(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]).unwrap();
    fan.validate().unwrap();
    let center = VertexId::new(0);
    assert!(fan.is_boundary_vertex(center));
    assert!(fan.is_exterior(fan.outgoing(center).next().unwrap()));
    assert_eq!(fan.one_ring(center).map(VertexId::get).collect::<Vec<_>>(), [4, 3, 2, 1]);
    assert_eq!(fan.faces_of_vertex(center).map(FaceId::get).collect::<Vec<_>>(), [2, 1, 0]);
    let [start] = fan.boundary_loops()[..] else { unreachable!("one loop") };
    let around: Vec<u32> = fan.boundary_loop(start).map(|h| fan.origin(h).get()).collect();
    assert_eq!(around, [1, 0, 4, 3, 2]);
    for h in fan.half_edges() {
        assert_eq!(fan.next(fan.previous(h)), h);
    }
}

#[test]
fn faces_keep_their_first_corner_and_half_edges_run_upwards() {
    let triangles = [[2, 0, 1], [3, 1, 0]];
    let topology = Topology::from_triangles(4, &triangles).unwrap();
    assert!(topology.triangles().eq(triangles));
    for edge in topology.edges() {
        let [a, b] = topology.edge_vertices(edge);
        assert!(a < b);
    }
}

#[test]
fn isolated_vertices_are_kept() {
    let topology = Topology::from_triangles(5, &[[0, 2, 4]]).unwrap();
    topology.validate().unwrap();
    assert!(topology.is_isolated_vertex(VertexId::new(1)));
    assert_eq!(topology.outgoing(VertexId::new(3)).count(), 0);
    assert_eq!(topology.euler_characteristic(), 1);
    assert_eq!(topology.components().count, 1);
}

#[test]
fn offences_are_told_apart() {
    let refuse = |vertices, triangles: &[[u32; 3]]| {
        Topology::from_triangles(vertices, triangles).unwrap_err()
    };
    assert_eq!(
        refuse(3, &[[0, 1, 3]]),
        TopologyError::IndexOutOfRange { face: 0, vertex: 3, vertex_count: 3 }
    );
    assert_eq!(refuse(3, &[[0, 1, 1]]), TopologyError::RepeatedVertex { face: 0, vertex: 1 });
    assert_eq!(
        refuse(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
        TopologyError::NonManifoldEdge { vertices: [0, 1], faces: 3 }
    );
    assert_eq!(
        refuse(4, &[[0, 1, 2], [0, 1, 3]]),
        TopologyError::InconsistentOrientation { vertices: [0, 1], faces: [0, 1] }
    );
    // Two triangles that touch in a vertex, open and closed.
    assert_eq!(refuse(5, &[[0, 1, 2], [0, 3, 4]]), TopologyError::PinchedVertex { vertex: 0 });
    let tetrahedra =
        [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0], [0, 4, 5], [0, 6, 4], [4, 6, 5], [5, 6, 0]];
    assert_eq!(refuse(7, &tetrahedra), TopologyError::PinchedVertex { vertex: 0 });
}

#[test]
fn genus_counts_handles() {
    let at = |i: u32, j: u32| (i % 4) * 3 + j % 3;
    let cells = (0..4).flat_map(|i| (0..3).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]]
        })
        .collect();
    let torus = Topology::from_triangles(12, &triangles).unwrap();
    assert_eq!((torus.euler_characteristic(), torus.genus()), (0, 1));
    let punctured = Topology::from_triangles(12, &triangles[1..]).unwrap();
    assert_eq!((punctured.euler_characteristic(), punctured.genus()), (-1, 1));
    assert_eq!(punctured.boundary_loops().len(), 1);
    assert!(torus.is_closed() && !punctured.is_closed());
}

#[test]
fn measures_of_a_box_far_from_the_origin() {
    let corner = |i: u32| {
        let bit = |k: u32| f64::from(i >> k & 1);
        [1e6 + 2.0 * bit(0), 1e6 + 3.0 * bit(1), 1e6 + 5.0 * bit(2)]
    };
    let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriMesh::from_triangles(&corners, &triangles).unwrap();
    assert!((mesh.area() - 62.0).abs() < 1e-8);
    assert!((mesh.volume() - 30.0).abs() < 1e-8);
    let bounds = mesh.bounding_box().unwrap();
    assert_eq!(bounds.extent().to_array(), [2.0, 3.0, 5.0]);
    let mut soup = PolygonSoup::new();
    corners.iter().for_each(|&corner| soup.push_vertex(corner));
    quads.iter().for_each(|quad| soup.push_face(quad).unwrap());
    let measures = soup.measure();
    assert!((measures.area - 62.0).abs() < 1e-8 && (measures.volume - 30.0).abs() < 1e-8);
    assert_eq!(measures.bounds, Some(bounds));
    // The diagonals of the quads differ from corner to corner; angle weights do not depend on them.
    let normals = mesh.vertex_normals();
    for (i, n) in normals.as_slice().iter().enumerate() {
        let sign = |k: usize| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
        let expected = glam::DVec3::new(sign(0), sign(1), sign(2)) / 3.0_f64.sqrt();
        assert!(n.distance(expected) < 1e-12, "vertex {i}: {n}");
    }
}

#[test]
fn positions_are_checked() {
    let bad = [[0.0, 0.0, 0.0], [1.0, f64::NAN, 0.0], [0.0, 1.0, 0.0]];
    assert!(TriMesh::from_triangles(&bad, &[[0, 1, 2]]).is_err());
    let topology = Topology::from_triangles(3, &[[0, 1, 2]]).unwrap();
    assert!(TriMesh::new(topology, vec![glam::DVec3::ZERO; 2]).is_err());
}

#[test]
fn handles_out_of_range_are_not_contained() {
    let topology = Topology::from_triangles(3, &[[0, 1, 2]]).unwrap();
    assert!(!topology.contains_vertex(VertexId::new(3)));
    assert!(!topology.contains_half_edge(HalfEdgeId::new(6)));
}
