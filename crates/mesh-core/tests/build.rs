//! Building meshes from soups: refusals and repairs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_core::build::{Sample, VertexPair};
use mesh_core::{BuildError, Built, PolygonSoup, Repair, Weld, build, diagnose};
use proptest::prelude::*;

fn soup(positions: &[[f64; 3]], faces: &[&[u32]]) -> PolygonSoup {
    let mut soup = PolygonSoup::new();
    positions.iter().for_each(|&position| soup.push_vertex(position));
    faces.iter().for_each(|face| soup.push_face(face).unwrap());
    soup
}

/// Vertices on a space curve, no four in a plane.
fn moment_curve(count: usize) -> Vec<[f64; 3]> {
    (0..count).map(|i| i as f64).map(|t| [t, t * t, t * t * t]).collect()
}

fn refuse(positions: &[[f64; 3]], faces: &[&[u32]], repair: &Repair) -> BuildError {
    build(&soup(positions, faces), repair).unwrap_err()
}

fn strict(faces: &[&[u32]]) -> BuildError {
    refuse(&moment_curve(8), faces, &Repair::strict())
}

fn lenient(faces: &[&[u32]]) -> Built {
    let built = build(&soup(&moment_curve(8), faces), &Repair::lenient()).unwrap();
    built.mesh.topology().validate().unwrap();
    built
}

/// Trap 3: coordinates that are not finite are a typed error, with and without repairs.
#[test]
fn trap_3_coordinates_that_are_not_finite_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut positions = moment_curve(4);
        positions[2][1] = bad;
        for repair in [Repair::strict(), Repair::lenient(), {
            let mut repair = Repair::lenient();
            repair.weld = Weld::Distance(0.5);
            repair
        }] {
            match refuse(&positions, &[&[0, 1, 2], &[0, 2, 3]], &repair) {
                BuildError::NonFiniteCoordinate { vertex: 2, vertices, .. } => {
                    assert_eq!(vertices.first(), [2]);
                }
                other => panic!("{other}"),
            }
        }
        // Unused and to be dropped: no reason to refuse.
        let built = build(&soup(&positions, &[&[0, 1, 3]]), &Repair::lenient()).unwrap();
        assert_eq!(built.report.dropped_vertices.first(), [2]);
    }
}

proptest! {
    /// Vertices that are nowhere are dropped with their faces, as if they had never been in the file.
    #[test]
    fn vertices_that_are_nowhere_are_dropped_with_their_faces(
        nowhere in prop::collection::vec((0_usize..36, 0_usize..3, 0_usize..3), 0..8),
        drops_unreferenced: bool,
    ) {
        let mut positions: Vec<[f64; 3]> =
            (0..36).map(|v| [f64::from(v % 6), f64::from(v / 6), f64::from(v * v % 7)]).collect();
        for (vertex, axis, value) in nowhere {
            positions[vertex][axis] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][value];
        }
        let cells = (0..25_u32).map(|cell| cell / 5 * 6 + cell % 5);
        let faces: Vec<[u32; 3]> =
            cells.flat_map(|a| [[a, a + 1, a + 7], [a, a + 7, a + 6]]).collect();
        let is_somewhere = |v: &u32| positions[*v as usize].iter().all(|x| x.is_finite());
        let kept: Vec<u32> = (0..36).filter(is_somewhere).collect();
        let new = |v: u32| kept.binary_search(&v).unwrap() as u32;
        let kept_faces: Vec<[u32; 3]> =
            faces.iter().filter(|face| face.iter().all(is_somewhere)).copied().collect();
        let kept_positions: Vec<[f64; 3]> = kept.iter().map(|&v| positions[v as usize]).collect();
        let mut repair = Repair::strict();
        repair.cut_non_manifold = true;
        repair.drop_unreferenced = drops_unreferenced;
        let renumbered: Vec<[u32; 3]> = kept_faces.iter().map(|face| face.map(new)).collect();
        let expected = PolygonSoup::from_triangles(&kept_positions, &renumbered).unwrap();
        let expected = build(&expected, &repair).unwrap();
        repair.drop_not_finite = true;
        let built = build(&PolygonSoup::from_triangles(&positions, &faces).unwrap(), &repair).unwrap();
        prop_assert_eq!(built.mesh.positions(), expected.mesh.positions());
        prop_assert!(built.mesh.topology().triangles().eq(expected.mesh.topology().triangles()));
        prop_assert_eq!(built.report.not_finite_vertices.count(), 36 - kept.len());
        prop_assert_eq!(built.report.dropped_not_finite.count(), 50 - kept_faces.len());
        let dropped = [&built, &expected].map(|built| built.report.dropped_vertices.count());
        prop_assert_eq!(dropped[0], dropped[1]);
    }
}

/// Trap 14: each kind of defect is its own error and names the elements.
#[test]
fn trap_14_a_pinched_vertex_is_refused_by_name() {
    // Two tetrahedra that share vertex 3.
    let faces: [&[u32]; 8] = [
        &[0, 2, 1],
        &[0, 1, 3],
        &[1, 2, 3],
        &[2, 0, 3],
        &[4, 6, 5],
        &[4, 5, 3],
        &[5, 6, 3],
        &[6, 4, 3],
    ];
    assert_eq!(
        strict(&faces),
        BuildError::PinchedVertex { vertex: 3, fans: 2, vertices: Sample::from_iter([3]) }
    );
    let built = lenient(&faces);
    assert_eq!(built.report.split_vertices.first(), [3]);
    assert_eq!(built.mesh.topology().components().count, 2);
    assert_eq!(built.mesh.topology().boundary_loops().len(), 0);
    assert_eq!(built.provenance.vertex_source, [0, 1, 2, 3, 4, 5, 6, 3]);
}

#[test]
fn trap_14_a_bow_tie_is_refused_by_name() {
    let faces: [&[u32]; 2] = [&[0, 1, 2], &[2, 3, 4]];
    assert_eq!(
        strict(&faces),
        BuildError::PinchedVertex { vertex: 2, fans: 2, vertices: Sample::from_iter([2]) }
    );
    assert_eq!(lenient(&faces).report.vertices_out, 6);
}

#[test]
fn trap_14_a_moebius_strip_is_refused_by_name() {
    let faces: [&[u32]; 5] = [&[0, 1, 2], &[1, 3, 2], &[2, 3, 4], &[3, 0, 4], &[4, 0, 1]];
    let mut reorient = Repair::strict();
    reorient.reorient = true;
    for repair in [Repair::strict(), reorient] {
        match refuse(&moment_curve(5), &faces, &repair) {
            BuildError::NonOrientable { edge, faces: [a, b], edges } => {
                assert_eq!(edges.first()[0], edge);
                for face in [a, b] {
                    let face = faces[face as usize];
                    assert!(face.contains(&edge.0) && face.contains(&edge.1));
                }
            }
            other => panic!("{other}"),
        }
    }
    let built = lenient(&faces);
    assert_eq!(built.mesh.topology().face_count(), 5);
    assert_eq!(built.report.cut_edges.count(), 1);
    assert_eq!(built.mesh.topology().euler_characteristic(), 1);
}

#[test]
fn trap_14_a_duplicate_face_is_refused_by_name() {
    let expected =
        BuildError::DuplicateFace { face: 2, original: 0, duplicates: Sample::from_iter([2]) };
    let faces: [&[u32]; 3] = [&[0, 1, 2], &[2, 1, 3], &[1, 2, 0]];
    assert_eq!(strict(&faces), expected);
    assert_eq!(lenient(&faces).report.dropped_duplicates.first(), [2]);
    // With opposite orientation, and although nothing else is wrong with it.
    let pillow: [&[u32]; 2] = [&[0, 1, 2], &[2, 1, 0]];
    assert!(matches!(strict(&pillow), BuildError::DuplicateFace { face: 1, original: 0, .. }));
    assert_eq!(lenient(&pillow).report.faces_out, 1);
}

#[test]
fn trap_14_an_edge_with_three_faces_is_refused_by_name() {
    let faces: [&[u32]; 3] = [&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]];
    assert_eq!(
        strict(&faces),
        BuildError::NonManifoldEdge {
            edge: VertexPair(0, 1),
            faces: Sample::from_iter([0, 1, 2]),
            edges: Sample::from_iter([VertexPair(0, 1)]),
        }
    );
    let built = lenient(&faces);
    assert_eq!(built.report.cut_edges.first(), [VertexPair(0, 1)]);
    assert_eq!(built.report.faces_out, 3);
}

#[test]
fn disagreeing_neighbours_are_refused_by_name() {
    let faces: [&[u32]; 3] = [&[0, 1, 2], &[1, 2, 3], &[0, 3, 1]];
    match strict(&faces) {
        BuildError::InconsistentOrientation { edge, faces, edges } => {
            assert_eq!((edge, faces, edges.count()), (VertexPair(1, 2), [0, 1], 2));
        }
        other => panic!("{other}"),
    }
    let closed: [&[u32]; 4] = [&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
    let built = lenient(&closed);
    assert_eq!(built.report.flipped_faces.count(), 1);
    assert_eq!(built.report.flipped_faces.first(), [0]);
    assert_eq!(built.provenance.corner_source[0], [0, 2, 1]);
}

#[test]
fn malformed_faces_are_refused_by_name() {
    assert!(matches!(
        strict(&[&[0, 1, 2], &[3, 9, 4]]),
        BuildError::IndexOutOfRange { face: 1, index: 9, vertex_count: 8, .. }
    ));
    assert!(matches!(
        strict(&[&[0, 1, 2], &[3, 4]]),
        BuildError::TooFewCorners { face: 1, corners: 2, .. }
    ));
    assert!(matches!(
        strict(&[&[0, 1, 2], &[3, 4, 3]]),
        BuildError::RepeatedVertex { face: 1, vertex: 3, .. }
    ));
    let built = lenient(&[&[0, 1, 2], &[3, 9, 4], &[3, 4], &[3, 4, 3], &[]]);
    assert_eq!(built.report.dropped_out_of_range.first(), [1]);
    assert_eq!(built.report.dropped_degenerate.first(), [2, 4, 3]);
    assert_eq!(built.provenance.face_source, [0]);
    let mut repair = Repair::strict();
    repair.weld = Weld::Distance(f64::NAN);
    let error = refuse(&moment_curve(3), &[&[0, 1, 2]], &repair);
    assert!(matches!(error, BuildError::InvalidWeldDistance { .. }));
}

/// Two closed surfaces that touch along an edge are separated into closed surfaces, without a slit.
#[test]
fn solids_that_touch_along_an_edge_come_apart_closed() {
    let faces: [&[u32]; 8] = [
        &[0, 2, 1],
        &[0, 1, 3],
        &[1, 2, 3],
        &[2, 0, 3],
        &[0, 5, 1],
        &[0, 1, 4],
        &[1, 5, 4],
        &[5, 0, 4],
    ];
    assert!(matches!(strict(&faces), BuildError::NonManifoldEdge { .. }));
    let built = lenient(&faces);
    let topology = built.mesh.topology();
    assert_eq!((topology.components().count, topology.boundary_loops().len()), (2, 0));
    assert_eq!((topology.vertex_count(), topology.edge_count()), (8, 12));
    assert_eq!(built.report.split_vertices.first(), [0, 1]);
}

#[test]
fn an_empty_soup_is_an_empty_mesh() {
    for repair in [Repair::strict(), Repair::lenient()] {
        let built = build(&PolygonSoup::new(), &repair).unwrap();
        assert_eq!(built.mesh.topology().face_count(), 0);
        assert!(built.report.is_unchanged());
    }
}

#[test]
fn seams_are_welded_only_when_asked() {
    let mut positions = moment_curve(3);
    positions.extend([positions[1], positions[2], [5.0, 0.0, 0.0]]);
    let soup = soup(&positions, &[&[0, 1, 2], &[4, 3, 5]]);
    let apart = build(&soup, &Repair::strict()).unwrap();
    assert!(apart.report.is_unchanged());
    assert_eq!(apart.mesh.topology().edge_count(), 6);
    let mut repair = Repair::strict();
    repair.weld = Weld::Exact;
    let welded = build(&soup, &repair).unwrap();
    assert_eq!(welded.mesh.topology().edge_count(), 5);
    assert_eq!(welded.report.welded_vertices.first(), [3, 4]);
    assert_eq!(welded.provenance.vertex_source, [0, 1, 2, 5]);
    assert_eq!(welded.provenance.corner_source, [[0, 1, 2], [3, 4, 5]]);
}

/// Checks the invariants between the parts of a build, for any accepted soup.
fn check_promises(soup: &PolygonSoup, built: &Built) {
    let topology = built.mesh.topology();
    topology.validate().unwrap();
    let provenance = &built.provenance;
    assert_eq!(provenance.face_source.len(), topology.face_count());
    assert_eq!(provenance.vertex_source.len(), topology.vertex_count());
    for face in topology.faces() {
        let corners = provenance.corner_source[face.index()];
        let range = soup.corner_range(provenance.face_source[face.index()] as usize);
        for (vertex, corner) in topology.face_vertices(face).into_iter().zip(corners) {
            assert!(range.contains(&(corner as usize)));
            let source = provenance.vertex_source[vertex.index()] as usize;
            assert_eq!(built.mesh.positions()[vertex.index()], soup.positions()[source]);
            let given = soup.corners()[corner as usize] as usize;
            assert_eq!(soup.positions()[source], soup.positions()[given]);
        }
    }
}

/// Two triangles with consistent orientation show their backs. The lenient build reverses both.
#[test]
fn a_sheet_that_shows_its_back_is_turned_as_a_whole() {
    let soup = PolygonSoup::from_triangles(&moment_curve(4), &[[2, 1, 3], [3, 0, 2]]).unwrap();
    assert!(build(&soup, &Repair::strict()).unwrap().report.is_unchanged());
    let report = build(&soup, &Repair::lenient()).unwrap().report;
    assert_eq!((report.flipped_faces.count(), report.turned_components.count()), (2, 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// The lenient build succeeds for any triangles and loses only what it reports.
    #[test]
    fn lenient_builds_any_triangles(
        vertices in 3_usize..12,
        faces in prop::collection::vec([0_u32..12, 0_u32..12, 0_u32..12], 0..40),
    ) {
        let faces: Vec<[u32; 3]> =
            faces.into_iter().map(|face| face.map(|v| v % vertices as u32)).collect();
        let soup = PolygonSoup::from_triangles(&moment_curve(vertices), &faces).unwrap();
        let built = build(&soup, &Repair::lenient()).unwrap();
        check_promises(&soup, &built);
        let sorted = |faces: &mut dyn Iterator<Item = [u32; 3]>| {
            let mut faces: Vec<[u32; 3]> = faces
                .map(|mut face| { face.sort_unstable(); face })
                .filter(|[a, b, c]| a != b && b != c)
                .collect();
            faces.sort_unstable();
            faces
        };
        let given = sorted(&mut faces.iter().copied());
        let source = &built.provenance.vertex_source;
        let made = built.mesh.topology().triangles();
        let made = sorted(&mut made.map(|face| face.map(|v| source[v as usize])));
        prop_assert_eq!(made.len(), given.len() - built.report.dropped_duplicates.count());
        // A wall between closed parts has two copies, a face none.
        let once = |mut faces: Vec<[u32; 3]>| { faces.dedup(); faces };
        prop_assert!(made.windows(3).all(|faces| faces[0] != faces[2]));
        prop_assert_eq!(once(made), once(given));
        prop_assert_eq!(diagnose(&built.mesh.to_soup()).unwrap().duplicate_faces, 0);
        if let Ok(strict) = build(&soup, &Repair::strict()) {
            prop_assert_eq!(strict.mesh.topology().face_count(), faces.len());
            prop_assert!(strict.report.is_unchanged());
            // Nothing is left to repair but unused vertices, and components that are inside out as a whole.
            let report = &built.report;
            prop_assert_eq!(report.flipped_faces.is_empty(), report.turned_components.is_empty());
            let is_left = report.dropped_vertices.is_empty() && report.turned_components.is_empty();
            prop_assert_eq!(is_left, report.is_unchanged());
        }
    }

    /// Polygons of any shape, on few vertices, some of which coincide.
    #[test]
    fn lenient_builds_any_polygons(
        positions in prop::collection::vec([0_u8..3, 0_u8..3, 0_u8..2], 1..10),
        faces in prop::collection::vec(prop::collection::vec(0_u32..11, 0..9), 0..12),
    ) {
        let positions: Vec<[f64; 3]> =
            positions.into_iter().map(|p| p.map(f64::from)).collect();
        let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
        let soup = soup(&positions, &faces);
        check_promises(&soup, &build(&soup, &Repair::lenient()).unwrap());
        if let Ok(strict) = build(&soup, &Repair::strict()) {
            check_promises(&soup, &strict);
        }
    }
}
