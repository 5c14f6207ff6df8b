//! Results are unchanged after a round trip through JSON.
#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use core::fmt::Debug;

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn assert_survives<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&text).unwrap(), *value, "{text}");
}

#[test]
fn options_and_results_survive() {
    let square = |z| {
        let corners = [[0.0, 0.0, z], [1.0, 0.0, 0.1], [1.0, 1.0, z], [0.0, 1.0, z]];
        Surface::new(&TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap()
    };
    let (a, b) = (square(0.0), square(2.0 / 3.0));
    let options = CompareOptions { samples: 100, ..CompareOptions::default() };
    assert_survives(&options);
    assert_survives(&compare(&a, &b, &options));
    let options = CertifyOptions { limit: Some(0.3), tolerance: 0.1, ..CertifyOptions::default() };
    assert_survives(&options);
    assert_survives(&hausdorff_bounds(&a, &b, &options));
    assert_survives(&a.closest(glam::DVec3::ONE));
}
