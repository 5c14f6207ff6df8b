//! What is lost of the content of a file, and why.

use crate::format::Format;
use crate::text::brief;
use std::fmt;

/// Why a scan loses everything but vertices and faces.
pub(crate) const STREAMED: &str = "only positions and faces are read from a stream";

/// A part of the content of a file that is not in the model, or not in the file that is written.
///
/// ```
/// use mesh_io::Lost;
///
/// let lost = Lost::some("tangents", 24, "write normals and texture coordinates instead");
/// assert_eq!(lost.to_string(), "tangents (24): write normals and texture coordinates instead");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Lost {
    /// What is lost, such as `groups` or `the PLY element "edge"`.
    pub what: String,
    /// How many of them, where they are counted.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub count: Option<u64>,
    /// Why, and how to keep it if there is a way.
    pub why: String,
}

impl Lost {
    /// A loss that is not counted. The texts become [printable](crate::printable).
    #[must_use]
    pub fn new(what: impl AsRef<str>, why: impl AsRef<str>) -> Self {
        Self { what: brief(what.as_ref()).into(), count: None, why: brief(why.as_ref()).into() }
    }

    /// A loss of `count` things.
    #[must_use]
    pub fn some(what: impl AsRef<str>, count: u64, why: impl AsRef<str>) -> Self {
        Self { count: Some(count), ..Self::new(what, why) }
    }

    /// A loss because of the format that is written; `keepers` are formats that keep it.
    pub(crate) fn by_format(
        what: impl AsRef<str>,
        count: Option<u64>,
        format: Format,
        keepers: &[Format],
    ) -> Self {
        let others: Vec<String> =
            keepers.iter().filter(|&&other| other != format).map(Format::to_string).collect();
        let why = match others.as_slice() {
            [] => format!("{format} files written here have no place for them"),
            others => format!("{format} has no place for them; {} keeps them", others.join(" or ")),
        };
        Self { count, ..Self::new(what, why) }
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            Some(count) => write!(f, "{} ({count}): {}", self.what, self.why),
            None => write!(f, "{}: {}", self.what, self.why),
        }
    }
}
