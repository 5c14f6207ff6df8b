//! Distances between a mesh and a coarser version of it: from samples, and by certified bounds.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{model_mesh, torus};
use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};
use simplify::{Options, Preset, simplify};

const MODELS: [(&str, usize); 3] =
    [("igea.ply", 3_000), ("rocker-arm.obj", 2_008), ("fandisk.obj", 1_294)];

/// Largest gap between the bounds, as a share of the diagonal of the bounding box.
const TOLERANCE: f64 = 1e-4;

/// A mesh and a coarser version of it, with their name.
struct Pair {
    name: String,
    fine: TriMesh,
    coarse: TriMesh,
}

impl Pair {
    fn new(name: &str, fine: TriMesh, faces: usize) -> Self {
        let options = Options::preset(Preset::Fast).to_faces(faces);
        let coarse = simplify(&fine, &options).unwrap().mesh;
        Self { name: name.into(), fine, coarse }
    }
}

fn pairs() -> Vec<Pair> {
    let torus = Pair::new("torus 100000", torus(100_000), 1_000);
    let models =
        MODELS.iter().filter_map(|&(name, faces)| Some(Pair::new(name, model_mesh(name)?, faces)));
    std::iter::once(torus).chain(models).collect()
}

fn distances(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("distance");
    group.sample_size(10);
    let samples = CompareOptions { samples: 100_000, ..CompareOptions::default() };
    for Pair { name, fine, coarse } in pairs() {
        let [a, b] = [&fine, &coarse].map(|mesh| Surface::new(mesh).unwrap());
        let faces = a.triangle_count() as u64;
        let tolerance = TOLERANCE * a.bounding_box().diagonal();
        let bounds = CertifyOptions { tolerance, ..CertifyOptions::default() };
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let id = |what| BenchmarkId::new(format!("{what}, {threads} threads"), &name);
            group.throughput(Throughput::Elements(faces));
            group.bench_function(id("hierarchy"), |bench| {
                bench.iter(|| pool.install(|| Surface::new(&fine).unwrap()));
            });
            // Samples of faces, per direction; samples of vertices and edges are extra.
            group.throughput(Throughput::Elements(2 * samples.samples as u64));
            group.bench_function(id("100,000 samples each way"), |bench| {
                bench.iter(|| pool.install(|| compare(&a, &b, &samples)));
            });
            group.throughput(Throughput::Elements(faces));
            group.bench_function(id("certified bounds"), |bench| {
                bench.iter(|| pool.install(|| hausdorff_bounds(&a, &b, &bounds)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, distances);
criterion_main!(benches);
