//! Written values can be read again.
#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use dcurv::{
    BallCurvature, CurvatureOptions, Curvatures, FittedCurvature, JetFitOptions, Totals,
    ball_curvatures, fitted_curvatures,
};
use mesh_core::{TriMesh, VertexMap};
use mesh_shapes::Torus;
use serde_json::{from_str, to_string};

#[test]
fn curvatures_totals_and_frames_come_back() {
    let torus = Torus { major: 2.0, minor: 1.0 }.mesh(12, 8).unwrap();
    let mesh = TriMesh::from_soup(&torus).unwrap();
    let all = Curvatures::of(&mesh, &CurvatureOptions::default());
    assert_eq!(from_str::<Curvatures>(&to_string(&all).unwrap()).unwrap(), all);
    assert_eq!(from_str::<Totals>(&to_string(&all.totals()).unwrap()).unwrap(), all.totals());
    let fits = fitted_curvatures(&mesh, &JetFitOptions::default());
    let read: VertexMap<Option<FittedCurvature>> = from_str(&to_string(&fits).unwrap()).unwrap();
    assert_eq!(read, fits);
    let balls = ball_curvatures(&mesh, 0.7).unwrap();
    let read: VertexMap<BallCurvature> = from_str(&to_string(&balls).unwrap()).unwrap();
    assert_eq!(read, balls);
    assert_eq!(
        from_str::<JetFitOptions>("{\"scale\": {\"rings\": 3}}").unwrap(),
        JetFitOptions::rings(3)
    );
    assert!(from_str::<JetFitOptions>("{\"rings\": 3}").is_err());
}
