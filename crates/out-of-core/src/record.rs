//! Records of regions on disk.

use serde::{Deserialize, Serialize};
use simplify::blocks::Forecast;

use crate::layout::Kind;
use crate::sealed_json::is_checksum;

/// The record of a region on disk.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The SHA-256 checksum of the file.
    pub sha256: String,
    /// The length of the file in bytes.
    pub bytes: u64,
    /// The number of faces that the cell owns.
    pub faces: u64,
    /// The number of faces that a pass would remove at each cost. Regions that can be collapsed have a forecast.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub forecast: Option<Forecast>,
    /// The proved distance between the faces of the cell before and after the step, in model units. `None` if no proof
    /// was requested, or no finite distance could be proved.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub moved: Option<f64>,
}

/// The bytes of a triangle in the file of a region.
const TRIANGLE: u64 = 12;

impl Record {
    /// Checks a record that was read. `proves` tells whether the run proves distances.
    pub(crate) fn check(&self, kind: Kind, proves: bool) -> Result<(), &'static str> {
        if !is_checksum(self.sha256.as_bytes()) {
            return Err("its checksum of the region is not one");
        }
        if self.faces > self.bytes / TRIANGLE {
            return Err("more faces than the region has bytes for");
        }
        if self.forecast.is_some() != (kind == Kind::Region) {
            return Err("a forecast of collapses where there are none, or none where there are");
        }
        if self.forecast.as_ref().is_some_and(|forecast| forecast.face_count() > self.bytes) {
            return Err("a forecast for more faces than the region has bytes for");
        }
        match self.moved {
            Some(_) if !proves || kind == Kind::Region => Err("a proof that was not asked for"),
            Some(moved) if !(moved >= 0.0 && moved.is_finite()) => Err("a distance below zero"),
            _ => Ok(()),
        }
    }
}
