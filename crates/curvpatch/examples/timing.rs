//! throw-away
#![allow(clippy::all, clippy::unwrap_used, clippy::print_stdout, missing_docs)]
use curvpatch::*;
use mesh_core::TriMesh;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&a[1]).unwrap();
    let (mut p, mut t) = (vec![], vec![]);
    for l in text.lines() {
        let w: Vec<&str> = l.split_whitespace().collect();
        if w.first() == Some(&"v") {
            p.push([1, 2, 3].map(|i| w[i].parse::<f64>().unwrap()));
        }
        if w.first() == Some(&"f") {
            t.push([1, 2, 3].map(|i| w[i].split('/').next().unwrap().parse::<u32>().unwrap() - 1));
        }
    }
    let m = TriMesh::from_triangles(&p, &t).unwrap();
    let top = m.topology();
    let h = top
        .edges()
        .map(|e| {
            let [a, b] = top.edge_vertices(e);
            m.position(a).distance(m.position(b))
        })
        .sum::<f64>()
        / top.edge_count() as f64;
    let diag = m.bounding_box().unwrap().diagonal();
    println!("faces {} h/diag {}", t.len(), h / diag);
    let e = CurvatureEstimator::new(&m, Params::robust()).unwrap();
    let s = Instant::now();
    let r = e.all_faces(4.0 * h).unwrap();
    println!(
        "curvature {:?} bad {}",
        s.elapsed(),
        r.as_slice().iter().filter(|x| x.is_err()).count()
    );
    let tol: f64 = a[2].parse().unwrap();
    let s = Instant::now();
    let mut o = CoverOptions::new(tol * diag);
    if a.len() > 3 {
        o.shapes = vec![Shape::Circle];
    }
    let c = cover(&e, &o).unwrap();
    println!(
        "cover {:?}: {} patches residual {} seeds {} candidates {} method {:?} max {}",
        s.elapsed(),
        c.patches.len(),
        c.residual.len(),
        c.seeds,
        c.candidates,
        c.method,
        c.max_error() / diag
    );
}
