//! The compared tools.

use std::fmt;
use std::path::PathBuf;

use simplify::Preset;

use super::drivers::{DRIVERS, Driver};

/// A tool and its settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Tool {
    /// One of our presets.
    Ours(Preset),
    /// One of our presets, with a certified largest error.
    OursProved(Preset),
    /// A preset run by another build of our program.
    OurProgram { name: String, program: PathBuf, preset: String },
    /// Another program.
    Other(&'static Driver),
}

impl Tool {
    /// All known tools, available or not.
    pub(super) fn all() -> Vec<Self> {
        let ours = Preset::ALL.iter().map(|&preset| Self::Ours(preset));
        let proved = Preset::ALL.iter().map(|&preset| Self::OursProved(preset));
        ours.chain(proved).chain(DRIVERS.iter().map(Self::Other)).collect()
    }

    /// The names of the program or library, and of its preset or method.
    pub(super) fn program_and_preset(&self) -> [String; 2] {
        match self {
            Self::Ours(_) | Self::OursProved(_) => ["curvmesh".into(), self.to_string()],
            Self::OurProgram { name, preset, .. } => [format!("curvmesh@{name}"), preset.clone()],
            Self::Other(driver) => [driver.program.into(), driver.method.into()],
        }
    }

    /// Whether it can stop at a largest error, or else at a number of faces.
    pub(super) fn can_do(&self, bounds_errors: bool) -> bool {
        match self {
            Self::Ours(_) | Self::OurProgram { .. } => true,
            Self::OursProved(_) => bounds_errors,
            Self::Other(driver) => driver.can_do(bounds_errors),
        }
    }

    /// The same preset, run by another program.
    pub(super) fn by_program(&self, name: &str, program: &str) -> Option<Self> {
        let Self::Ours(preset) = self else { return None };
        Some(Self::OurProgram {
            name: name.into(),
            program: program.into(),
            preset: preset.to_string(),
        })
    }
}

impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ours(preset) => write!(f, "{preset}"),
            Self::OursProved(preset) => write!(f, "{preset}-proved"),
            Self::OurProgram { name, preset, .. } => write!(f, "{preset}@{name}"),
            Self::Other(driver) => f.write_str(driver.name),
        }
    }
}
