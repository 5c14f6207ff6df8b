//! A mesh on disk, which is streamed as often as an operation needs.

use std::path::PathBuf;

use mesh_core::BoundingBox;
use mesh_io::ReadOptions;

use crate::capacity::Memory;
use crate::cells::Cells;
use crate::error::Error;
use crate::ingest::{Ingested, Input, Summary};
use crate::region::Region;
use crate::scratch_folder::ScratchFolder;
use crate::split::{Repairs, split};
use crate::step::Step;

/// A mesh in the files of a folder. Operations on it keep to the memory limit that it was read with, apart from one bit
/// for each vertex, and for each corner of a format without vertices.
///
/// The files hold positions and faces. [`Summary::notes`] names the other contents of the input, which are left out.
pub struct DiskMesh {
    pub(crate) ingested: Ingested,
    pub(crate) folder: PathBuf,
    pub(crate) memory: Memory,
}

impl DiskMesh {
    /// Reads a file into the folder `name` of the scratch folder. `memory` is the limit in bytes.
    ///
    /// # Errors
    /// The input cannot be read, all faces have a corner whose position is not finite, the files cannot be written, or
    /// the memory limit is too small.
    pub fn read(
        scratch: &ScratchFolder,
        name: &str,
        input: Input<'_>,
        reading: &ReadOptions,
        memory: u64,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let memory = Memory::new(memory)?;
        let folder = scratch.inner(name)?;
        let of = match &input {
            Input::Path(path) => std::fs::metadata(path).map_or(0, |metadata| metadata.len()),
            Input::Stream(..) => 0,
        };
        let reads = &mut |done| observer(Step { what: "reading", done, of, level: 0 });
        let ingested = Ingested::read(input, reading, false, &folder, memory.stream(), reads)?;
        Ok(Self { ingested, folder, memory })
    }

    /// The statistics of the input.
    #[must_use]
    pub fn summary(&self) -> &Summary {
        &self.ingested.summary
    }

    /// Calls `visit` with one region after the other. The memory of the process divided by `bytes_per_face` limits the
    /// number of faces of a region.
    pub(crate) fn each_region(
        &self,
        bytes_per_face: u64,
        repairs: Repairs,
        observer: &mut dyn FnMut(Step) -> bool,
        visit: &mut dyn FnMut(Region) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let depth = self.memory.depth(self.ingested.summary.triangles, bytes_per_face)?;
        let cells = Cells::new(self.ingested.sample.clone(), depth);
        let of = u64::from(cells.count());
        let mut done = 0;
        split(
            &self.ingested,
            &cells,
            repairs,
            &self.folder,
            self.memory.stream(),
            &mut |region| {
                visit(region)?;
                done += 1;
                let step = Step { what: "computing", done, of, level: 0 };
                if observer(step) { Ok(()) } else { Err(Error::Stopped) }
            },
        )?;
        Ok(())
    }

    /// The bounding box of all vertices, whether faces use them or not.
    pub(crate) fn bounds(&self) -> Option<BoundingBox> {
        self.ingested.summary.bounds
    }
}
