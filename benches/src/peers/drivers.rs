//! The other programs, as data.
//!
//! A driver is a program that gets a name, a target, threads, repeats, and two files: it reads a raw mesh and writes a
//! mesh, and answers with a line (see [`super::job`]). The folder `drivers` has them.

use crate::compiled::Library;

/// A program or library with one of its methods, and how it is run.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Driver {
    /// The name on the command line, in the record, and for the driver.
    pub(super) name: &'static str,
    /// The name in pages.
    pub(super) title: &'static str,
    /// The program or library, and its method.
    pub(super) program: &'static str,
    pub(super) method: &'static str,
    pub(super) runs: Runs,
}

/// What a driver is written in, and needs.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Runs {
    /// A function of `simplify.py`; a package of the Python index and its module.
    Python { package: &'static str, module: &'static str },
    /// A part of `gltf.mjs`; a package of npm.
    Node { package: &'static str },
    /// A compiled program.
    Compiled(&'static Library),
    /// A part of this program, with the feature `meshopt`.
    Here,
}

const fn python(package: &'static str, module: &'static str) -> Runs {
    Runs::Python { package, module }
}

const CGAL: Runs = Runs::Compiled(&Library {
    name: "cgal",
    driver: include_str!("drivers/cgal.cpp"),
    clone: "cgal",
    is_required: false,
    headers: &["include"],
    sources: &[],
    flags: &["-O3", "-lgmp", "-lmpfr"],
});

const PMP: Runs = Runs::Compiled(&Library {
    name: "pmp",
    driver: include_str!("drivers/pmp.cpp"),
    clone: "pmp-library",
    is_required: true,
    headers: &["src"],
    sources: &[
        "src/pmp/surface_mesh.cpp",
        "src/pmp/algorithms/decimation.cpp",
        "src/pmp/algorithms/distance_point_triangle.cpp",
        "src/pmp/algorithms/normals.cpp",
    ],
    flags: &["-O3", "-DPMP_SCALAR_TYPE_64"],
});

const fn driver(
    name: &'static str,
    title: &'static str,
    [program, method]: [&'static str; 2],
    runs: Runs,
) -> Driver {
    Driver { name, title, program, method, runs }
}

/// All drivers.
pub(super) static DRIVERS: [Driver; 22] = [
    driver("cgal-lt", "CGAL Lindstrom-Turk", ["cgal", "lindstrom-turk"], CGAL),
    driver("cgal-gh", "CGAL Garland-Heckbert", ["cgal", "garland-heckbert"], CGAL),
    driver("cgal-probabilistic", "CGAL probabilistic", ["cgal", "probabilistic-plane"], CGAL),
    driver("meshlab", "MeshLab", ["meshlab", "default"], python("pymeshlab", "pymeshlab")),
    driver("meshlib", "MeshLib", ["meshlib", "default"], python("meshlib", "meshlib")),
    driver("open3d", "Open3D", ["open3d", "default"], python("open3d", "open3d")),
    driver("manifold", "manifold", ["manifold", "default"], python("manifold3d", "manifold3d")),
    driver("meshoptimizer", "meshoptimizer", ["meshoptimizer", "simplify"], Runs::Here),
    driver(
        "meshoptimizer-permissive",
        "meshoptimizer, permissive",
        ["meshoptimizer", "permissive"],
        Runs::Here,
    ),
    driver(
        "meshoptimizer-normals",
        "meshoptimizer, with normals",
        ["meshoptimizer", "attributes: normals"],
        Runs::Here,
    ),
    driver("gltfpack", "gltfpack", ["gltfpack", "-si -se 1"], Runs::Node { package: "gltfpack" }),
    driver(
        "gltf-transform",
        "glTF-Transform",
        ["gltf-transform", "weld, simplify"],
        Runs::Node { package: "@gltf-transform/functions" },
    ),
    driver(
        "fast-simplification",
        "fast-simplification",
        ["fast-simplification", "default"],
        python("fast-simplification", "fast_simplification"),
    ),
    driver("pyfqmr", "pyfqmr", ["pyfqmr", "default"], python("pyfqmr", "pyfqmr")),
    driver("vtk-quadric", "VTK, quadric", ["vtk", "quadric"], python("vtk", "vtkmodules")),
    driver("vtk-pro", "VTK, decimate pro", ["vtk", "decimate-pro"], python("vtk", "vtkmodules")),
    driver("libigl", "libigl", ["libigl", "qslim"], python("libigl", "igl")),
    driver(
        "gpytoolbox",
        "gpytoolbox",
        ["gpytoolbox", "shortest edge"],
        python("gpytoolbox", "gpytoolbox"),
    ),
    driver("trueform", "trueform", ["trueform", "decimated"], python("trueform", "trueform")),
    driver("zmesh", "zmesh", ["zmesh", "simplify"], python("zmesh", "zmesh")),
    driver("blender", "Blender", ["blender", "decimate, collapse"], python("bpy", "bpy")),
    driver("pmp", "pmp", ["pmp", "decimate"], PMP),
];

/// Programs without a driver, and the reason.
pub(super) const ABSENT: [(&str, &str); 3] = [
    ("trimesh", "it calls fast-simplification"),
    ("CGAL, lines", "the policy is in no release up to 6.1.1"),
    ("Simplygon, InstaLOD, Houdini", "they need a licence"),
];

impl Driver {
    /// The driver of a name.
    pub(super) fn of_name(name: &str) -> Option<&'static Self> {
        DRIVERS.iter().find(|driver| driver.name == name)
    }

    /// Whether it can stop at a largest error, or else at a number of faces.
    pub(super) fn can_do(&self, bounds_errors: bool) -> bool {
        match self.name {
            "meshlib" => true,
            "manifold" => bounds_errors,
            _ => !bounds_errors,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_driver_is_in_its_source_once() {
        for (index, Driver { name, runs, .. }) in DRIVERS.iter().enumerate() {
            let (source, entry) = match runs {
                Runs::Python { .. } => {
                    (include_str!("drivers/simplify.py"), format!("\n    \"{name}\": ("))
                }
                Runs::Node { .. } => (include_str!("drivers/gltf.mjs"), (*name).to_owned()),
                Runs::Compiled(library) => (library.driver, (*name).to_owned()),
                Runs::Here => (include_str!("job.rs"), (*name).to_owned()),
            };
            assert!(source.contains(&entry), "{name}");
            assert!(DRIVERS[..index].iter().all(|other| other.name != *name), "{name}");
            assert_eq!(Driver::of_name(name).map(|driver| driver.name), Some(*name));
        }
        assert_eq!(Driver::of_name("trimesh"), None);
    }
}
