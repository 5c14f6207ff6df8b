//! What the tests share.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)]

use mesh_core::shapes::Torus;
use mesh_core::{PolygonSoup, TriMesh};

pub(crate) const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };

pub(crate) fn mesh_of(soup: &PolygonSoup) -> TriMesh {
    let triangles: Vec<[u32; 3]> = soup.faces().map(|f| [f[0], f[1], f[2]]).collect();
    TriMesh::from_triangles(soup.positions(), &triangles).unwrap()
}

/// The shifted torus of DHKL01 sec. 4.
pub(crate) fn paper_torus() -> TriMesh {
    mesh_of(&TORUS.shifted_mesh(12, 6).unwrap())
}

/// The faces as sorted triples, each starting with its smallest vertex.
pub(crate) fn face_set(mesh: &TriMesh) -> Vec<[u32; 3]> {
    mesh.topology().canonical_triangles()
}

/// A mesh from the folder named by `CURVMESH_MODELS`; says so when there is none.
pub(crate) fn model(name: &str) -> Option<TriMesh> {
    let Some(folder) = std::env::var_os("CURVMESH_MODELS") else {
        println!("skipped: set CURVMESH_MODELS");
        return None;
    };
    let path = std::path::Path::new(&folder).join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: {} is not there", path.display());
        return None;
    };
    let (points, triangles) =
        if name.ends_with(".off") { parse_off(&text) } else { parse_obj(&text) };
    Some(TriMesh::from_triangles(&points, &triangles).unwrap())
}

fn numbers<T: std::str::FromStr>(words: &[&str]) -> Vec<T> {
    words.iter().filter_map(|word| word.parse().ok()).collect()
}

fn parse_obj(text: &str) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => points.push(numbers::<f64>(&words[1..])[..3].try_into().unwrap()),
            Some(&"f") => {
                let corner = |word: &&str| word.split('/').next().unwrap().parse::<u32>().unwrap();
                let corners: Vec<u32> = words[1..].iter().map(|w| corner(w) - 1).collect();
                triangles.push(corners[..].try_into().unwrap());
            }
            _ => {}
        }
    }
    (points, triangles)
}

fn parse_off(text: &str) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut words = text.split_whitespace().skip(1);
    let mut next = || words.next().unwrap();
    let [vertices, faces, _] = [(); 3].map(|()| next().parse::<usize>().unwrap());
    let points = (0..vertices).map(|_| [(); 3].map(|()| next().parse().unwrap())).collect();
    let triangles = (0..faces)
        .map(|_| {
            assert_eq!(next(), "3");
            [(); 3].map(|()| next().parse().unwrap())
        })
        .collect();
    (points, triangles)
}
