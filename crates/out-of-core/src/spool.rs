//! A mesh that was read as a stream and lies on disk, to be passed through as often as it takes.

use std::path::PathBuf;

use mesh_core::BoundingBox;
use mesh_io::ReadOptions;

use crate::cells::Cells;
use crate::claim::ScratchFolder;
use crate::error::Error;
use crate::incoming::{Incoming, Input, Summary};
use crate::region::Region;
use crate::sizes::Memory;
use crate::split::{Repairs, split};
use crate::work::Step;

/// A mesh in the files of a folder. What is done with it takes no more memory than was allowed when it was
/// read, save for one bit for each vertex, and for each corner of a format without vertices.
///
/// There are positions and faces; what else the input had was passed over, and [`Summary::notes`] say what.
pub struct Spool {
    pub(crate) incoming: Incoming,
    pub(crate) folder: PathBuf,
    pub(crate) memory: Memory,
}

impl Spool {
    /// Reads a PLY, STL or OBJ file. `name` is that of the folder within the scratch folder; `memory` are the
    /// bytes that may be taken, and `see` is told how far it is and says whether to go on.
    ///
    /// # Errors
    /// The input cannot be read or has a coordinate that is not finite, the files cannot be written, or it is too
    /// little memory.
    pub fn read(
        scratch: &ScratchFolder,
        name: &str,
        input: Input<'_>,
        reading: &ReadOptions,
        memory: u64,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let memory = Memory::new(memory)?;
        let folder = scratch.inner(name)?;
        let of = match &input {
            Input::Path(path) => std::fs::metadata(path).map_or(0, |metadata| metadata.len()),
            Input::Stream(..) => 0,
        };
        let reads = &mut |done| see(Step { what: "reading", done, of, level: 0 });
        let incoming = Incoming::read(input, reading, &folder, memory.stream(), reads)?;
        Ok(Self { incoming, folder, memory })
    }

    /// What is known of the mesh.
    #[must_use]
    pub fn summary(&self) -> &Summary {
        &self.incoming.summary
    }

    /// Calls `visit` with one region after the other, of which each has so many bytes for each face.
    pub(crate) fn each_region(
        &self,
        bytes_per_face: u64,
        repairs: Repairs,
        see: &mut dyn FnMut(Step) -> bool,
        visit: &mut dyn FnMut(Region) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let depth = self.memory.depth(self.incoming.summary.triangles, bytes_per_face);
        let cells = Cells::new(self.incoming.sample.clone(), depth);
        let of = u64::from(cells.count());
        let mut done = 0;
        split(&self.incoming, &cells, repairs, &self.folder, self.memory.stream(), &mut |region| {
            visit(region)?;
            done += 1;
            let step = Step { what: "computing", done, of, level: 0 };
            if see(step) { Ok(()) } else { Err(Error::Stopped) }
        })
    }

    /// The box round all vertices, in use or not.
    pub(crate) fn bounds(&self) -> Option<BoundingBox> {
        self.incoming.summary.bounds
    }
}
