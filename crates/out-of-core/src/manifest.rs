//! The manifest of a run: its settings, its input, its cells.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use simplify::{Options, Target, rules};

use crate::capacity::Capacity;
use crate::cells::Cells;
use crate::error::Error;
use crate::ingest::Summary;
use crate::split::Repairs;

/// The settings of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    /// How the mesh is simplified. `target` must contain a number of faces or a ratio.
    pub options: Options,
    /// Further results, levels of detail. Each names a number of faces or a ratio. Results are sorted by their numbers
    /// of faces, so they may be coarser than the result of `options`.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub finer_levels: Vec<Target>,
    /// The defects of the input that are repaired.
    pub repairs: Repairs,
    /// Limits of the number of faces in memory.
    pub capacity: Capacity,
    /// The tolerance to which the distance from the input is proved in each pass, as a share of the diagonal of the
    /// bounding box. `None`: nothing is proved.
    pub prove: Option<f64>,
}

impl Settings {
    /// Checks that the run can be done region by region.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if rules(&self.options, 1.0).is_none() {
            return Err(Error::Unsupported(
                "this set of options",
                "take a preset with quadrics, without constraints and limits other than a number of faces",
            ));
        }
        if !self.finer_levels.iter().all(is_count) {
            return Err(Error::Unsupported(
                "a level of detail",
                "name a number of faces or a ratio for each, and nothing else",
            ));
        }
        if self.prove.is_some_and(|share| !(share > 0.0 && share.is_finite())) {
            return Err(Error::Unsupported(
                "a proof to a tolerance that is not a positive number",
                "name the share of the diagonal to which distances are proved, such as 1e-4",
            ));
        }
        Ok(())
    }

    /// The numbers of faces of all results, from the finest to the coarsest. The input has `faces` faces.
    pub(crate) fn targets(&self, faces: u64) -> Vec<u64> {
        let faces = usize::try_from(faces).unwrap_or(usize::MAX);
        let limits = self.finer_levels.iter().chain([&self.options.target]);
        let mut targets: Vec<u64> =
            limits.map(|limits| limits.face_target(faces).min(faces) as u64).collect();
        targets.sort_unstable_by(|a, b| b.cmp(a));
        targets
    }
}

/// Whether the target is a number of faces or a ratio and nothing else.
fn is_count(limits: &Target) -> bool {
    let Target { faces, ratio, time: None, vertices: None, cost: None, collapses: None } = limits
    else {
        return false;
    };
    faces.is_some() || ratio.is_some()
}

/// The content of `run.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// The settings of the run.
    pub settings: Settings,
    /// The identity of the input.
    pub input: InputIdentity,
    /// The statistics of the input.
    pub summary: Summary,
    /// The partition of space into cells.
    pub cells: Cells,
}

impl Manifest {
    /// Checks a manifest that was read: its numbers may be wrong.
    pub(crate) fn check(&self, path: &Path) -> Result<(), Error> {
        let Self { settings, summary, cells, .. } = self;
        settings.check()?;
        summary.check().map_err(|reason| Error::damaged(path, reason))?;
        let depth = settings.capacity.checked_depth(summary.triangles)?;
        cells.check(depth).map_err(|reason| Error::damaged(path, reason))
    }
}

/// The properties by which an input is recognised.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputIdentity {
    /// Its name, without the folder.
    pub name: String,
    /// Its length in bytes; `None` for a stream.
    pub bytes: Option<u64>,
    /// When it was last changed, in nanoseconds since 1970; `None` for a stream.
    pub changed: Option<u128>,
}

impl InputIdentity {
    /// The identity of a file.
    ///
    /// # Errors
    /// There is no such file.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let metadata = fs::metadata(path).map_err(Error::io(path))?;
        let since = |time: std::time::SystemTime| time.duration_since(std::time::UNIX_EPOCH).ok();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let changed = metadata.modified().ok().and_then(since).map(|time| time.as_nanos());
        Ok(Self { name, bytes: metadata.is_file().then_some(metadata.len()), changed })
    }
}
