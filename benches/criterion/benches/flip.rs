//! Edge flips, whole runs: F2 from 10k to 1M faces and on real meshes, F1 and F3 up to 100k faces.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{SIZES, model_mesh};
use dcurv::VertexArea;
use dtri_flip::{AbsMean, FlipCost, FlipOptions, VertexCost, VertexFunction, optimise};
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
    let vertex_cost = |function| VertexCost { function, area: VertexArea::Voronoi };
    run(criterion, "flip f1", &vertex_cost(VertexFunction::SquaredMean), 100_000);
    run(criterion, "flip f2", &AbsMean, usize::MAX);
    run(criterion, "flip f3", &vertex_cost(VertexFunction::AbsPrincipal), 100_000);
}

fn run<C: FlipCost>(criterion: &mut Criterion, name: &str, cost: &C, max_faces: usize) {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let meshes = meshes().into_iter();
    for (name, mesh) in meshes.filter(|(_, mesh)| mesh.topology().face_count() <= max_faces) {
        group.throughput(Throughput::Elements(mesh.topology().face_count() as u64));
        group.bench_function(BenchmarkId::new("one thread", &name), |b| {
            b.iter_batched_ref(
                || mesh.clone(),
                |mesh| pool.install(|| optimise(mesh, cost, &FlipOptions::default()).unwrap()),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, flip);
criterion_main!(benches);
