//! Reading a file into a validated half-edge mesh. Needs `CURVMESH_MODELS`.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::model;
use mesh_core::build::{Repair, build};

fn read(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("read");
    group.sample_size(20);
    for name in ["igea.ply", "igea.obj", "armadillo_52k.off", "conrod.stl", "engine_2cyl.glb"] {
        let Some(path) = model(name) else {
            println!("{name}: skipped, set CURVMESH_MODELS to a folder that has it");
            continue;
        };
        group.throughput(Throughput::Bytes(path.metadata().unwrap().len()));
        group.bench_function(BenchmarkId::new("file to soup", name), |b| {
            b.iter(|| mesh_io::read(&path).unwrap());
        });
        group.bench_function(BenchmarkId::new("file to validated mesh", name), |b| {
            b.iter(|| {
                let model = mesh_io::read(&path).unwrap();
                let built = build(&model.soup, &Repair::lenient()).unwrap();
                built.mesh.topology().validate().unwrap();
                built
            });
        });
    }
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);
