//! How often a scrambled convex hull is found again, by cost and strategy (DHKL01 sec. 4).
//!
//! Arguments: the number of seeds (50) and of points (60), and one of the strategies by number.
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::ops::ControlFlow;

use common::{face_set, mesh_of, scramble};
use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, Quad};
use mesh_core::shapes::{Ellipsoid, Sphere, SplitMix64};
use mesh_core::{EdgeId, TriMesh};
use rayon::prelude::*;

/// Whether a flip keeps the triangulation of a surface round the origin without overlaps.
fn stays_embedded(mesh: &TriMesh, edge: EdgeId) -> bool {
    Quad::around(mesh.topology(), edge).is_some_and(|quad| {
        quad.flipped_triangles().iter().all(|t| {
            let [a, b, c] = t.map(|v| mesh.position(v));
            a.dot(b.cross(c)) > 0.0
        })
    })
}

fn strategies() -> Vec<(&'static str, FlipOptions)> {
    let look_ahead = |look_ahead| FlipOptions { look_ahead, ..Default::default() };
    let anneal = |look_ahead, rounds, steps_per_edge| FlipOptions {
        look_ahead,
        anneal: Some(Anneal { rounds, steps_per_edge, ..Default::default() }),
        ..Default::default()
    };
    vec![
        ("greedy", look_ahead(1)),
        ("look-ahead 2", look_ahead(2)),
        ("look-ahead 3", look_ahead(3)),
        ("anneal", anneal(1, 8, 50)),
        ("anneal, ahead 3", anneal(3, 8, 50)),
    ]
}

fn main() {
    let args: Vec<usize> = std::env::args().skip(1).map(|a| a.parse().unwrap()).collect();
    let seeds = args.first().copied().unwrap_or(50) as u64;
    let points = args.get(1).copied().unwrap_or(60);
    for shape in ["sphere", "ellipsoid"] {
        for (name, options) in strategies() {
            if args.get(2).is_some_and(|&only| strategies()[only].0 != name) {
                continue;
            }
            for cost in [CostName::F1, CostName::F2, CostName::F3] {
                print!("{points:4} {shape:10} {name:20} {cost}");
                for embedded in [false, true] {
                    print!("  {}", if embedded { "embedded" } else { "free" });
                    for k in [20, 60, 150, 600] {
                        let found = (0..seeds)
                            .into_par_iter()
                            .filter(|&seed| {
                                finds_hull(shape, points, seed, k, embedded, cost, &options)
                            })
                            .count();
                        print!(" {k}: {found:2}");
                    }
                }
                println!();
            }
        }
    }
}

fn finds_hull(
    shape: &str,
    points: usize,
    seed: u64,
    k: usize,
    embedded: bool,
    cost: CostName,
    options: &FlipOptions,
) -> bool {
    let soup = match shape {
        "sphere" => Sphere { radius: 1.0 }.random_hull(points, seed),
        _ => Ellipsoid { semi_axes: glam::DVec3::new(3.0, 2.0, 1.0) }.random_hull(points, seed),
    };
    let mut mesh = mesh_of(&soup.unwrap());
    let hull = face_set(&mesh);
    scramble(&mut mesh, k, &mut SplitMix64::new(1000 + seed), |mesh, edge| {
        !embedded || stays_embedded(mesh, edge)
    });
    cost.optimise(&mut mesh, VertexArea::Voronoi, options, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    face_set(&mesh) == hull
}
