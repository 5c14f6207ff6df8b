//! Building half-edge meshes from triangles: M faces per second, by size.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use criterion_benches::{SIZES, torus_soup, triangles};
use mesh_core::build::{Repair, build};
use mesh_core::{Topology, TriMesh};

fn half_edges(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build");
    group.sample_size(20);
    for faces in SIZES {
        let soup = torus_soup(faces);
        let triangles = triangles(&soup);
        group.throughput(Throughput::Elements(triangles.len() as u64));
        group.bench_function(BenchmarkId::new("topology", faces), |b| {
            b.iter(|| Topology::from_triangles(soup.vertex_count(), &triangles).unwrap());
        });
        group.bench_function(BenchmarkId::new("strict", faces), |b| {
            b.iter(|| build(&soup, &Repair::strict()).unwrap());
        });
        group.bench_function(BenchmarkId::new("lenient", faces), |b| {
            b.iter(|| build(&soup, &Repair::lenient()).unwrap());
        });
        group.bench_function(BenchmarkId::new("validate", faces), |b| {
            let mesh = TriMesh::from_triangles(soup.positions(), &triangles).unwrap();
            b.iter(|| mesh.topology().validate().unwrap());
        });
        print_memory(&soup, &triangles);
    }
    group.finish();
}

#[allow(clippy::print_stdout)]
fn print_memory(soup: &mesh_core::PolygonSoup, triangles: &[[u32; 3]]) {
    let mesh = TriMesh::from_triangles(soup.positions(), triangles).unwrap();
    let bytes = mesh.heap_bytes() as f64 / soup.vertex_count() as f64;
    println!("{} faces: {bytes:.1} bytes per vertex, topology and positions", triangles.len());
}

criterion_group!(benches, half_edges);
criterion_main!(benches);
