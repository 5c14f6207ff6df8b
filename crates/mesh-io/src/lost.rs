//! Content of a file that is lost, with the reason.

use crate::format::Format;
use crate::text::brief;
use std::fmt;

/// The reason why a scan loses everything except vertices and faces.
pub(crate) const STREAMED: &str = "only positions and faces are read from a stream";

/// A part of the content of a file that is missing in the model or in the written file.
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
    /// The number of lost elements, if counted.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub count: Option<u64>,
    /// The reason, and a way to keep it if there is one.
    pub why: String,
}

impl Lost {
    /// A loss without a count. The texts become [printable](crate::printable).
    #[must_use]
    pub fn new(what: impl AsRef<str>, why: impl AsRef<str>) -> Self {
        Self { what: brief(what.as_ref()).into(), count: None, why: brief(why.as_ref()).into() }
    }

    /// A loss of `count` elements.
    #[must_use]
    pub fn some(what: impl AsRef<str>, count: u64, why: impl AsRef<str>) -> Self {
        Self { count: Some(count), ..Self::new(what, why) }
    }

    /// A loss caused by the output format; `keepers` are formats that keep the content.
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
