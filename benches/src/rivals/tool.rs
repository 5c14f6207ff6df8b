//! The compared tools. Each is a driver that takes a method, a value, a number of repeats and two files.

use xtask_common::Failure;

/// What a tool does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Flips,
    Distances,
}

/// Where a tool comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Program {
    /// Our libraries, called by this program.
    Ours,
    /// A C++ program with the headers of CGAL.
    Cgal,
    /// A Python package.
    Python(&'static Package),
}

/// A Python package.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Package {
    /// The name in the index of packages, and the version.
    pub(super) requirement: &'static str,
    /// The module to import.
    pub(super) module: &'static str,
}

static MESHLAB: Package = Package { requirement: "pymeshlab==2025.7.post1", module: "pymeshlab" };
static MESHLIB: Package = Package { requirement: "meshlib==3.1.4.297", module: "meshlib" };
static LIBIGL: Package = Package { requirement: "libigl==2.6.3", module: "igl" };
static OPEN3D: Package = Package { requirement: "open3d-cpu==0.20.0", module: "open3d" };
static CASCADING: Package =
    Package { requirement: "cascading-upper-bounds==1.0.0", module: "cascading_upper_bounds" };

impl Package {
    /// The name without the version.
    pub(super) fn distribution(&self) -> &'static str {
        self.requirement.split_once("==").map_or(self.requirement, |(name, _)| name)
    }
}

/// What the value of a driver is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value {
    None,
    /// The largest difference between the bounds.
    Tolerance,
    /// Points in each direction.
    Samples,
}

/// A tool and its method.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Tool {
    pub(super) kind: Kind,
    /// The name on the command line and in records.
    pub(super) name: &'static str,
    /// The name in tables.
    pub(super) label: &'static str,
    pub(super) program: Program,
    /// The method of the driver.
    pub(super) method: &'static str,
    pub(super) value: Value,
}

const fn flips(
    name: &'static str,
    label: &'static str,
    program: Program,
    method: &'static str,
) -> Tool {
    Tool { kind: Kind::Flips, name, label, program, method, value: Value::None }
}

const fn distances(
    name: &'static str,
    label: &'static str,
    program: Program,
    method: &'static str,
    value: Value,
) -> Tool {
    Tool { kind: Kind::Distances, name, label, program, method, value }
}

use Program::{Cgal, Ours, Python};
use Value::{Samples, Tolerance};

/// All tools. The first of each kind is the one that others are compared with.
static TOOLS: [Tool; 20] = [
    flips("f2", "`f2`", Ours, "f2"),
    flips("f1", "`f1`", Ours, "f1"),
    flips("f3", "`f3`", Ours, "f3"),
    flips("delaunay", "`delaunay`", Ours, "delaunay"),
    flips("area", "`area`", Ours, "area"),
    flips("meshlab-mean", "MeshLab, mean curvature", Python(&MESHLAB), "meshlab-curvature mean"),
    flips(
        "meshlab-norm-squared",
        "MeshLab, norm squared",
        Python(&MESHLAB),
        "meshlab-curvature norm squared",
    ),
    flips(
        "meshlab-absolute",
        "MeshLab, absolute curvature",
        Python(&MESHLAB),
        "meshlab-curvature absolute",
    ),
    flips("meshlab-delaunay", "MeshLab, Delaunay", Python(&MESHLAB), "meshlab-planar delaunay"),
    flips("meshlab-area", "MeshLab, area", Python(&MESHLAB), "meshlab-planar area/max side"),
    flips("meshlib-delaunay", "MeshLib, Delaunay", Python(&MESHLIB), "meshlib-delaunay"),
    flips("libigl-delaunay", "libigl, intrinsic Delaunay", Python(&LIBIGL), "libigl-delaunay"),
    distances("proved", "curvmesh, proved", Ours, "proved", Tolerance),
    distances("cascading", "cascading upper bounds", Python(&CASCADING), "cascading", Tolerance),
    distances("cgal-bounded", "CGAL, bounded error", Cgal, "bounded", Tolerance),
    distances("sampled", "curvmesh, sampled", Ours, "sampled", Samples),
    distances("cgal-sampled", "CGAL, sampled", Cgal, "sampled", Samples),
    distances("meshlab-sampled", "MeshLab, sampled", Python(&MESHLAB), "meshlab", Samples),
    distances("open3d-sampled", "Open3D, sampled", Python(&OPEN3D), "open3d", Samples),
    distances("libigl-vertices", "libigl, vertices", Python(&LIBIGL), "libigl", Value::None),
];

impl Tool {
    /// All tools of a kind.
    pub(super) fn all(kind: Kind) -> impl Iterator<Item = &'static Self> {
        TOOLS.iter().filter(move |tool| tool.kind == kind)
    }

    /// Finds the tools by their names.
    pub(super) fn chosen(kind: Kind, names: &[String]) -> Result<Vec<&'static Self>, Failure> {
        let find = |name: &String| {
            Self::all(kind).find(|tool| tool.name == name).ok_or_else(|| {
                let names: Vec<&str> = Self::all(kind).map(|tool| tool.name).collect();
                Failure::Usage(format!("there is no tool {name}; there are {}", names.join(", ")))
            })
        };
        names.iter().map(find).collect()
    }
}
