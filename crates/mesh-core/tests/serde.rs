//! Written values can be read again, and read values are sound.
#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use mesh_core::SplitMix64;
use mesh_core::build::{BuildReport, Sample};
use mesh_core::{
    BoundingBox, FaceId, HalfEdgeId, PolygonSoup, Repair, Topology, TriMesh, VertexId, VertexMap,
    Weld, build,
};
use mesh_shapes::{Torus, polyhedra};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, from_str, from_value, json, to_string, to_value};

fn there_and_back<T: Serialize + DeserializeOwned>(value: &T) -> T {
    from_str(&to_string(value).unwrap()).unwrap()
}

#[test]
fn meshes_keep_all_handles_also_beside_gaps() {
    let torus = Torus { major: 2.0, minor: 1.0 }.mesh(8, 5).unwrap();
    let mut mesh = TriMesh::from_soup(&torus).unwrap();
    for h in [2, 31, 80].map(HalfEdgeId::new) {
        if let Ok(collapse) = mesh.topology().check_collapse(h) {
            mesh.collapse(collapse, [0.0; 3].into());
        }
    }
    let removal = mesh.topology().check_remove_face(FaceId::new(40)).unwrap();
    mesh.remove_face(removal);
    mesh.add_vertex([1.0; 3]).unwrap();
    assert!(!mesh.topology().is_compact());
    let copy = there_and_back(&mesh);
    let (a, b) = (mesh.topology(), copy.topology());
    b.validate().unwrap();
    assert!(a.half_edges().eq(b.half_edges()) && a.faces().eq(b.faces()));
    assert!(a.vertices().eq(b.vertices()));
    for h in a.half_edges() {
        assert_eq!((a.next(h), a.target(h), a.face(h)), (b.next(h), b.target(h), b.face(h)));
    }
    assert!(a.vertices().all(|v| mesh.position(v) == copy.position(v)));
    assert!(a.vertices().all(|v| a.half_edge_of_vertex(v) == b.half_edge_of_vertex(v)));
    assert_eq!(to_string(&mesh).unwrap(), to_string(&copy).unwrap());
}

#[test]
fn maps_soups_and_reports_come_back() {
    let heights: VertexMap<f64> = [0.1, 0.2].into_iter().collect();
    assert_eq!(to_string(&heights).unwrap(), "[0.1,0.2]");
    assert_eq!(there_and_back(&heights), heights);
    assert_eq!(to_string(&VertexId::new(7)).unwrap(), "7");
    assert_eq!(there_and_back(&Some(FaceId::new(3))), Some(FaceId::new(3)));
    let mut soup = polyhedra::cube();
    soup.push_face(&[0, 1, 2, 99]).unwrap();
    assert_eq!(there_and_back(&soup), soup);
    let built = build(&soup, &Repair::lenient()).unwrap();
    assert_eq!(there_and_back(&built.report), built.report);
    assert_eq!(there_and_back(&built.provenance), built.provenance);
    let mut repair = Repair::lenient();
    repair.weld = Weld::Distance(0.25);
    assert_eq!(there_and_back(&repair), repair);
    assert_eq!(from_str::<Repair>("{\"reorient\": true}").unwrap().weld, Weld::None);
    assert!(from_str::<Repair>("{\"reorientate\": true}").is_err());
    let bounds = built.mesh.bounding_box().unwrap();
    assert_eq!(there_and_back::<BoundingBox>(&bounds), bounds);
    let diagnosis = mesh_core::diagnose(&soup).unwrap();
    assert_eq!(there_and_back(&diagnosis), diagnosis);
    assert_eq!(from_str::<BuildReport>("{}").unwrap(), BuildReport::default());
}

#[test]
fn wrong_data_is_refused_with_a_reason() {
    let refuse = |json: &str, reason: &str| {
        let error = from_str::<TriMesh>(json).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    };
    let mesh = |vertices: &str, faces: &str, half_edges: &str, positions: &str| {
        format!(
            "{{\"topology\": {{\"vertices\": {vertices}, \"faces\": {faces}, \
             \"half_edges\": {half_edges}}}, \"positions\": {positions}}}"
        )
    };
    refuse(&mesh("[]", "[]", "[[0, 0, 0]]", "[]"), "counts");
    refuse(&mesh("[5]", "[]", "[]", "[[0, 0, 0]]"), "v0");
    refuse(&mesh("[4294967295]", "[]", "[]", "[]"), "0 positions for 1 vertices");
    refuse(&mesh("[]", "[7]", "[]", "[]"), "f0");
    refuse(&mesh("[]", "[]", "[[1, 9, 9], [0, 9, 9]]", "[]"), "not in the mesh");
    refuse(&mesh("[]", "[]", "[[1, 4294967295, 0], [0, 0, 0]]", "[]"), "index of a vertex");
    assert!(from_str::<VertexId>("4294967294").is_err());
    assert!(from_str::<VertexId>("-1").is_err());
    let soup = |ends: &str| {
        format!("{{\"positions\": [], \"corners\": [1, 2, 3], \"face_ends\": {ends}}}")
    };
    assert!(from_str::<PolygonSoup>(&soup("[3]")).is_ok());
    for ends in ["[]", "[2]", "[4]", "[2, 1, 3]", "[4294967295]"] {
        assert!(from_str::<PolygonSoup>(&soup(ends)).is_err(), "{ends}");
    }
    assert!(from_str::<Sample<u32>>("{\"count\": 1, \"first\": [1, 2]}").is_err());
    assert!(from_str::<Sample<u32>>("{\"count\": 9, \"first\": [1, 2]}").is_err());
}

/// All numbers in a document, to be changed.
fn numbers(value: &mut Value) -> Vec<&mut Value> {
    match value {
        Value::Array(items) => items.iter_mut().flat_map(numbers).collect(),
        Value::Object(members) => members.values_mut().flat_map(numbers).collect(),
        Value::Number(_) => vec![value],
        _ => Vec::new(),
    }
}

/// Meshes with numbers changed at random are refused, or are sound: iterations over them end.
#[test]
fn changed_numbers_never_make_a_broken_mesh() {
    let mut random = SplitMix64::new(9);
    let mut plane = Topology::from_triangles(5, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let split = plane.check_split_edge(plane.edges().next().unwrap()).unwrap();
    plane.split_edge(split);
    let collapse = plane.half_edges().find_map(|h| plane.check_collapse(h).ok()).unwrap();
    plane.collapse(collapse);
    let octahedron = TriMesh::from_soup(&polyhedra::octahedron()).unwrap().topology().clone();
    let (mut accepted, mut refused) = (0, 0);
    for topology in [plane, octahedron] {
        let document = to_value(&topology).unwrap();
        for _ in 0..20_000 {
            let mut changed = document.clone();
            let mut all = numbers(&mut changed);
            for _ in 0..1 + random.bits() % 3 {
                let at = (random.bits() % all.len() as u64) as usize;
                let special = [0, 1, u64::from(u32::MAX), u64::from(u32::MAX) - 1];
                let value = match random.bits() % 4 {
                    0 => special[(random.bits() % 4) as usize],
                    _ => random.bits() % 40,
                };
                *all[at] = json!(value);
            }
            match from_value::<Topology>(changed) {
                Ok(topology) => {
                    accepted += 1;
                    topology.validate().unwrap();
                    for v in topology.vertices() {
                        assert!(topology.valence(v) < 40);
                    }
                    assert!(topology.boundaries().map(Iterator::count).sum::<usize>() < 40);
                }
                Err(_) => refused += 1,
            }
        }
    }
    println!("{accepted} accepted, {refused} refused");
    assert!(refused > 30_000);
}
