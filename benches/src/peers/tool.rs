//! The compared tools.

use std::fmt;
use std::path::PathBuf;

use simplify::Preset;

/// A tool and its settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Tool {
    /// One of our presets.
    Ours(Preset),
    /// One of our presets, with a certified largest error.
    OursProved(Preset),
    /// A preset run by another build of our program.
    OurProgram { name: String, program: PathBuf, preset: String },
    /// meshoptimizer's `simplify`.
    Meshopt,
    /// CGAL's Lindstrom-Turk.
    CgalLindstromTurk,
    /// CGAL's Garland-Heckbert with its guard of normals.
    CgalGarlandHeckbert,
    /// A package of the virtual environment.
    Python(Package),
}

/// A package with a function for it in `simplify.py`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Package {
    MeshLab,
    FastSimplification,
    MeshLib,
    Open3d,
    Manifold,
    Pyfqmr,
    VtkQuadric,
    VtkPro,
    Libigl,
}

impl Package {
    pub(super) const ALL: [Self; 9] = [
        Self::MeshLab,
        Self::FastSimplification,
        Self::MeshLib,
        Self::Open3d,
        Self::Manifold,
        Self::Pyfqmr,
        Self::VtkQuadric,
        Self::VtkPro,
        Self::Libigl,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::MeshLab => "meshlab",
            Self::FastSimplification => "fast-simplification",
            Self::MeshLib => "meshlib",
            Self::Open3d => "open3d",
            Self::Manifold => "manifold",
            Self::Pyfqmr => "pyfqmr",
            Self::VtkQuadric => "vtk-quadric",
            Self::VtkPro => "vtk-pro",
            Self::Libigl => "libigl",
        }
    }

    /// The name in the index of packages.
    pub(super) fn distribution(self) -> &'static str {
        match self {
            Self::MeshLab | Self::Manifold => self.module(),
            Self::VtkQuadric | Self::VtkPro => "vtk",
            Self::FastSimplification
            | Self::MeshLib
            | Self::Open3d
            | Self::Pyfqmr
            | Self::Libigl => self.name(),
        }
    }

    /// The module to import.
    pub(super) fn module(self) -> &'static str {
        match self {
            Self::MeshLab => "pymeshlab",
            Self::FastSimplification => "fast_simplification",
            Self::MeshLib => "meshlib",
            Self::Open3d => "open3d",
            Self::Manifold => "manifold3d",
            Self::Pyfqmr => "pyfqmr",
            Self::VtkQuadric | Self::VtkPro => "vtkmodules",
            Self::Libigl => "igl",
        }
    }
}

impl Tool {
    /// All known tools, available or not.
    pub(super) fn all() -> Vec<Self> {
        let ours = Preset::ALL.iter().map(|&preset| Self::Ours(preset));
        let proved = Preset::ALL.iter().map(|&preset| Self::OursProved(preset));
        let programs = [Self::CgalLindstromTurk, Self::CgalGarlandHeckbert, Self::Meshopt];
        let packages = Package::ALL.map(Self::Python);
        ours.chain(proved).chain(programs).chain(packages).collect()
    }

    /// The names of the program or library, and of its preset or method.
    pub(super) fn program_and_preset(&self) -> [String; 2] {
        match self {
            Self::Ours(_) | Self::OursProved(_) => ["curvmesh".into(), self.to_string()],
            Self::OurProgram { name, preset, .. } => [format!("curvmesh@{name}"), preset.clone()],
            Self::Meshopt => [self.to_string(), "simplify".into()],
            Self::CgalLindstromTurk => ["cgal".into(), "lindstrom-turk".into()],
            Self::CgalGarlandHeckbert => ["cgal".into(), "garland-heckbert".into()],
            Self::Python(Package::VtkQuadric) => ["vtk".into(), "quadric".into()],
            Self::Python(Package::VtkPro) => ["vtk".into(), "decimate-pro".into()],
            Self::Python(Package::Libigl) => ["libigl".into(), "qslim".into()],
            Self::Python(package) => [package.name().into(), "default".into()],
        }
    }

    /// Whether it can stop at a largest error, or else at a number of faces.
    pub(super) fn can_do(&self, bounds_errors: bool) -> bool {
        match self {
            Self::Ours(_) | Self::OurProgram { .. } => true,
            Self::Python(Package::MeshLib) => true,
            Self::OursProved(_) | Self::Python(Package::Manifold) => bounds_errors,
            _ => !bounds_errors,
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
            Self::Meshopt => f.write_str("meshoptimizer"),
            Self::CgalLindstromTurk => f.write_str("cgal-lt"),
            Self::CgalGarlandHeckbert => f.write_str("cgal-gh"),
            Self::Python(package) => f.write_str(package.name()),
        }
    }
}
