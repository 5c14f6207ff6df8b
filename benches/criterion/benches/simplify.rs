//! Edge collapses, whole runs: tori from 10k to 1M faces to one percent, and real meshes.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{SIZES, model_mesh, torus};
use mesh_core::TriMesh;
use simplify::{Options, Preset, simplify};

/// Real meshes and their target numbers of faces.
const MODELS: [(&str, usize); 3] =
    [("igea.ply", 3_000), ("rocker-arm.obj", 2_008), ("fandisk.obj", 1_294)];

/// Every mesh with its name and its target number of faces.
fn meshes() -> Vec<(String, TriMesh, usize)> {
    let tori = SIZES.iter().map(|&faces| (format!("torus {faces}"), torus(faces), faces / 100));
    let models = MODELS.iter().filter_map(|&(name, faces)| {
        Some((format!("{name} to {faces}"), model_mesh(name)?, faces))
    });
    tori.chain(models).collect()
}

fn collapses(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let meshes = meshes();
    for preset in [Preset::Draft, Preset::Fast, Preset::Default, Preset::PaperL1Guarded] {
        let mut group = criterion.benchmark_group(format!("simplify {preset}"));
        group.sample_size(10);
        for (name, mesh, faces) in &meshes {
            // Each of ten samples would take minutes.
            if preset == Preset::PaperL1Guarded && mesh.topology().face_count() > 500_000 {
                continue;
            }
            let options = Options::preset(preset).to_faces(*faces);
            group.throughput(Throughput::Elements(mesh.topology().face_count() as u64));
            group.bench_function(BenchmarkId::new("one thread", name), |b| {
                b.iter(|| pool.install(|| simplify(mesh, &options).unwrap()));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, collapses);
criterion_main!(benches);
