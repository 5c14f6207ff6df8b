//! Memory of the collapses, measured by a counting allocator.
#![allow(clippy::unwrap_used)]

use mesh_core::TriMesh;
use mesh_shapes::Torus;
use peak_alloc::PeakAlloc;
use simplify::{Options, Preset, RefineOptions, memory_needed, simplify};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

#[test]
fn collapses_take_no_more_than_is_said() {
    let soup = Torus { major: 5.0, minor: 2.0 }.mesh(640, 320).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    drop(soup);
    let faces = mesh.topology().face_count();
    // Bytes per face of the input, besides the fixed part. Large meshes are closer to the estimate.
    for (preset, record, most) in
        [(Preset::Draft, false, 150), (Preset::Fast, true, 190), (Preset::Default, true, 420)]
    {
        for ratio in [0.01, 0.1, 0.3] {
            let mut options = Options::preset(preset).to_faces((ratio * faces as f64) as usize);
            options.record = record;
            options.refine = RefineOptions::none();
            let before = ALLOCATOR.current_usage();
            ALLOCATOR.reset_peak_usage();
            let result = simplify(&mesh, &options).unwrap();
            let taken = ALLOCATOR.peak_usage() - before;
            drop(result);
            let said = memory_needed(&mesh, &options) as usize;
            assert!(taken < said, "{preset} {ratio}: {taken} of {said}");
            assert!(taken < most * faces, "{preset} {ratio}: {} for each face", taken / faces);
        }
    }
}
