//! All curvatures of all vertices: M vertices per second, by number of threads and size.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{SIZES, model_mesh, torus};
use dcurv::{CurvatureOptions, Curvatures};
use mesh_core::TriMesh;

fn meshes() -> Vec<(String, TriMesh)> {
    let mut meshes: Vec<_> = SIZES.iter().map(|&f| (format!("torus {f}"), torus(f))).collect();
    meshes.extend(model_mesh("igea.ply").map(|mesh| ("igea".into(), mesh)));
    meshes
}

fn curvature(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("curvature");
    for (name, mesh) in meshes() {
        group.throughput(Throughput::Elements(mesh.topology().vertex_count() as u64));
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let id = BenchmarkId::new(format!("{threads} threads"), &name);
            group.bench_function(id, |b| {
                b.iter(|| pool.install(|| Curvatures::of(&mesh, &CurvatureOptions::default())));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, curvature);
criterion_main!(benches);
