//! Edge flips for F2, the whole run: from 10k to 1M faces, and on real meshes.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{SIZES, model_mesh};
use dtri_flip::{AbsMean, FlipOptions, optimise};
use mesh_core::TriMesh;
use mesh_shapes::Torus;

/// The torus of DHKL01 with more points: half of its edges are worth flipping.
fn shifted_torus(faces: usize) -> TriMesh {
    let sides = ((faces / 4) as f64).sqrt().round() as usize;
    let rings = (faces / (4 * sides)) * 2;
    let soup = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(rings, sides).unwrap();
    TriMesh::from_soup(&soup).unwrap()
}

fn meshes() -> Vec<(String, TriMesh)> {
    let mut meshes: Vec<_> =
        SIZES.iter().map(|&faces| (format!("torus {faces}"), shifted_torus(faces))).collect();
    for name in ["rocker-arm.obj", "fandisk.obj", "armadillo_52k.off", "igea.ply"] {
        meshes.extend(model_mesh(name).map(|mesh| (name.into(), mesh)));
    }
    meshes
}

fn flip(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("flip f2");
    group.sample_size(10);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (name, mesh) in meshes() {
        group.throughput(Throughput::Elements(mesh.topology().face_count() as u64));
        group.bench_function(BenchmarkId::new("one thread", &name), |b| {
            b.iter_batched_ref(
                || mesh.clone(),
                |mesh| pool.install(|| optimise(mesh, &AbsMean, &FlipOptions::default()).unwrap()),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, flip);
criterion_main!(benches);
