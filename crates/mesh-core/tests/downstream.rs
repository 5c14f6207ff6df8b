//! Functions that a crate downstream of `mesh-core` needs.
#![allow(clippy::unwrap_used)]

use mesh_core::glam::{DVec3, Vec3};
use mesh_core::{
    FaceId, FaceMap, FaceTree, MeshError, PolygonSoup, Topology, TriMesh, VertexId, VertexMap,
};
use mesh_shapes::{Plane, Sphere, Torus, polyhedra};

const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };

#[test]
fn positions_and_indices_of_many_types_are_the_same_mesh() {
    let double = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.5, 0.0]];
    let single = double.map(|p| p.map(|x| x as f32));
    let expected = TriMesh::from_triangles(&double, &[[0_u32, 1, 2]]).unwrap();
    let same = |mesh: Result<TriMesh, MeshError>| {
        let mesh = mesh.unwrap();
        assert_eq!(mesh.positions(), expected.positions());
        assert!(mesh.topology().triangles().eq(expected.topology().triangles()));
    };
    same(TriMesh::from_triangles(&single, &[[0_usize, 1, 2]]));
    same(TriMesh::from_triangles(&single.map(Vec3::from), &[[0_u16, 1, 2]]));
    same(TriMesh::from_triangles(&double.map(|[x, y, z]| (x, y, z)), &[[0_i64, 1, 2]]));
    same(TriMesh::from_triangles(&double.each_ref(), &[[0, 1, 2]]));
    same(TriMesh::from_flat(double.as_flattened(), &[0_u8, 1, 2]));
    same(TriMesh::from_flat(single.as_flattened(), &[0_u64, 1, 2]));
    let mut soup = PolygonSoup::new();
    single.iter().for_each(|p| soup.push_vertex(p));
    soup.push_face(&[0_usize, 1, 2]).unwrap();
    same(TriMesh::from_soup(&soup));

    let negative = TriMesh::from_triangles(&double, &[[0, -1, 2]]).unwrap_err();
    assert!(matches!(negative, MeshError::Topology(_)), "{negative}");
    assert!(TriMesh::from_triangles(&double, &[[0, 1 << 32, 2_u64]]).is_err());
    let odd = TriMesh::from_flat(&[0.0; 10], &[0, 1, 2]).unwrap_err();
    assert_eq!(odd.to_string(), "there are 10 coordinates, which is not a multiple of three");
}

#[test]
fn a_soup_of_an_edited_mesh_is_that_of_the_compacted_one() {
    let mut mesh = TriMesh::from_soup(&TORUS.mesh(12, 8).unwrap()).unwrap();
    let whole = mesh.to_soup();
    assert!(
        TriMesh::from_soup(&whole).unwrap().topology().triangles().eq(mesh.topology().triangles())
    );
    for h in [3, 50, 77, 120].map(mesh_core::HalfEdgeId::new) {
        if let Ok(collapse) = mesh.topology().check_collapse(h) {
            let middle = mesh.position(mesh.topology().target(h));
            mesh.collapse(collapse, middle);
        }
    }
    let soup = PolygonSoup::from(&mesh);
    mesh.compact();
    assert_eq!(soup, mesh.to_soup());
    assert!(soup.face_count() < whole.face_count());
}

#[test]
fn maps_are_as_handy_as_vectors() {
    let mesh = TriMesh::from_soup(&polyhedra::octahedron()).unwrap();
    let topology = mesh.topology();
    let mut heights: VertexMap<f64> =
        VertexMap::from_fn(topology, |v: VertexId| mesh.position(v).z);
    for (vertex, height) in heights.iter_mut() {
        *height += f64::from(vertex.get());
    }
    let collected: VertexMap<f64> = heights.as_slice().iter().copied().collect();
    assert_eq!(collected, heights);
    let signs = heights.map(|h| *h > 2.0);
    let high = heights.zip(&signs).filter(|(_, _, sign)| **sign).count();
    assert_eq!(high, signs.iter().filter(|(_, sign)| **sign).count());
    assert_eq!(FaceMap::<u8>::default().len(), 0);
    let mut growing = FaceMap::default();
    assert_eq!(growing.insert(FaceId::new(2), 7), 0);
    growing.grow_with(topology, 9);
    assert_eq!(format!("{growing:?}"), "{f0: 0, f1: 0, f2: 7, f3: 9, f4: 9, f5: 9, f6: 9, f7: 9}");
    growing.extend([1]);
    assert_eq!(growing.live(topology).count(), 8);
}

#[test]
fn lengths_centres_and_neighbours() {
    let mesh = TriMesh::from_soup(&polyhedra::octahedron()).unwrap();
    let topology = mesh.topology();
    let edge = topology.edges().next().unwrap();
    let [a, b] = mesh.segment(edge);
    assert_eq!(mesh.edge_length(edge), a.distance(b));
    assert_eq!(mesh.edge_lengths().len(), 12);
    assert!((mesh.mean_edge_length().unwrap() - 2.0_f64.sqrt()).abs() < 1e-15);
    for face in topology.faces() {
        assert!((mesh.face_centroid(face).length() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15);
        for (edge, neighbour) in
            topology.face_edges(face).into_iter().zip(topology.face_neighbours(face))
        {
            let neighbour = neighbour.unwrap();
            assert!(topology.face_edges(neighbour).contains(&edge));
            assert!(topology.face_neighbours(neighbour).contains(&Some(face)));
        }
    }
    let lone = TriMesh::from_triangles(&[[0.0; 3]], &[] as &[[u32; 3]]).unwrap();
    assert_eq!(lone.mean_edge_length(), None);
}

#[test]
fn boundaries_run_round_the_holes() {
    let plane = TriMesh::from_soup(&Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap());
    let plane = plane.unwrap();
    let topology = plane.topology();
    let loops: Vec<Vec<VertexId>> =
        topology.boundaries().map(|edges| edges.map(|h| topology.origin(h)).collect()).collect();
    assert_eq!(loops.len(), 1);
    assert_eq!(loops[0].len(), 16);
    assert!(loops[0].iter().all(|&v| topology.is_boundary_vertex(v)));
}

#[test]
fn pieces_share_out_the_mesh() {
    let torus = TORUS.mesh(8, 6).unwrap();
    let sphere = Sphere::UNIT.icosphere(1).unwrap();
    let mut soup = torus.clone();
    soup.push_vertex([9.0; 3]);
    let shift = soup.vertex_count() as u32;
    sphere.positions().iter().for_each(|&p| soup.push_vertex(p + DVec3::splat(10.0)));
    for face in sphere.faces() {
        let face: Vec<u32> = face.iter().map(|v| v + shift).collect();
        soup.push_face(&face).unwrap();
    }
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let pieces = mesh.split_components().unwrap();
    let sizes: Vec<_> = pieces.iter().map(|p| p.mesh.topology().face_count()).collect();
    assert_eq!(sizes, [torus.face_count(), sphere.face_count()]);
    assert!(pieces.iter().map(|p| p.mesh.topology().genus()).eq([1, 0]));
    for piece in &pieces {
        let topology = piece.mesh.topology();
        assert_eq!(topology.components().count, 1);
        for face in topology.faces() {
            let whole = piece.face_source[face.index()];
            assert_eq!(piece.mesh.triangle(face), mesh.triangle(whole));
        }
        for (vertex, &source) in topology.vertices().zip(&piece.vertex_source) {
            assert_eq!(piece.mesh.position(vertex), mesh.position(source));
        }
    }
}

#[test]
fn the_laplacian_is_symmetric_and_kills_linear_functions_in_the_plane() {
    let plane = Plane { half_width: 1.0 }.irregular_mesh(8, Default::default()).unwrap();
    let mesh = TriMesh::from_soup(&plane).unwrap();
    let topology = mesh.topology();
    let laplacian = mesh.cotangent_laplacian();
    assert_eq!(laplacian.len(), topology.vertex_count() + 2 * topology.edge_count());
    assert!(laplacian.windows(2).all(|w| (w[0].row, w[0].column) < (w[1].row, w[1].column)));
    let mut image = topology.vertex_map(0.0);
    let mut energy = 0.0;
    for entry in &laplacian {
        let value = |v: VertexId| mesh.position(v).dot(DVec3::new(1.0, -2.0, 0.0));
        image[entry.row] += entry.value * value(entry.column);
        energy -= value(entry.row) * entry.value * value(entry.column);
        let mirrored = laplacian.iter().find(|e| (e.row, e.column) == (entry.column, entry.row));
        assert_eq!(mirrored.unwrap().value, entry.value);
    }
    for vertex in topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)) {
        assert!(image[vertex].abs() < 1e-13, "{}", image[vertex]);
    }
    // The Dirichlet energy is the area times the square of the gradient.
    assert!((energy - 5.0 * mesh.area()).abs() < 1e-12);

    // On a sphere, L x = -2 H n A, summed against the normal.
    let sphere = TriMesh::from_soup(&Sphere::UNIT.icosphere(4).unwrap()).unwrap();
    let energy: f64 = sphere
        .cotangent_laplacian()
        .iter()
        .map(|e| e.value * sphere.position(e.row).dot(sphere.position(e.column)))
        .sum();
    assert!((energy + 2.0 * sphere.area()).abs() < 1e-10 * sphere.area());
}

#[test]
fn a_face_tree_follows_splits() {
    let mut mesh = TriMesh::from_soup(&Sphere::UNIT.icosphere(2).unwrap()).unwrap();
    let mut tree = FaceTree::new(&mesh);
    for step in 0..400 {
        let topology = mesh.topology();
        let face = topology.faces().nth((37 * step) % topology.face_count()).unwrap();
        let position = 1.3 * mesh.face_centroid(face);
        let split = topology.check_split_face(face).unwrap();
        let made = mesh.split_face(split, position);
        tree.update(&mesh, made.faces.into_iter().chain([face]));
    }
    // Faces that were never in the mesh are ignored.
    tree.update(&mesh, [FaceId::new(1_000_000)]);
    for face in mesh.topology().faces() {
        let bounds = mesh_core::BoundingBox::of_triangle(mesh.triangle(face));
        assert_eq!(tree.find(&mesh, bounds, |f| f == face), Some(face));
    }
    let mut empty =
        TriMesh::from_triangles(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]], &[] as &[[u32; 3]]).unwrap();
    let mut tree = FaceTree::new(&empty);
    let first = empty.topology().check_add_face([0, 1, 2].map(VertexId::new)).unwrap();
    let face = empty.add_face(first).face;
    tree.update(&empty, [face]);
    let bounds = empty.bounding_box().unwrap();
    assert_eq!(tree.find(&empty, bounds, |_| true), Some(face));
}

#[test]
fn edges_between_vertices_of_many_edges_are_found() {
    // Two hubs, with and without an edge between them, around a ring of many vertices.
    let n = 500_u32;
    let double_cone = |i: u32| [[i, (i + 1) % n, n], [(i + 1) % n, i, n + 1]];
    let faces: Vec<[u32; 3]> = (0..n).flat_map(double_cone).collect();
    let topology = Topology::from_triangles(n as usize + 2, &faces).unwrap();
    let [low, high] = [n, n + 1].map(VertexId::new);
    assert_eq!(topology.find_half_edge(low, high), None);
    for i in (0..n).step_by(7).map(VertexId::new) {
        for (from, to) in [(i, low), (low, i), (high, i), (i, high)] {
            let h = topology.find_half_edge(from, to).unwrap();
            assert_eq!((topology.origin(h), topology.target(h)), (from, to));
        }
    }
}
