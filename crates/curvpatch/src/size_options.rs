//! Options for the size of a patch.

use crate::test_points::TEST_ANGLES;

/// Where the tolerance of a patch is tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ErrorTest {
    /// At test points with u = 1/2 and u = 1, and at all vertices over or under the footprint.
    #[default]
    Full,
    /// At the ends of the principal arcs only, as SN10 (section 3) proposes.
    ///
    /// Errors between the arcs stay undetected: on an exact cylinder the error of these four points is 0,
    /// and the error at φ = 45° is a³/32 of the radius, a = `r_g` κ₁.
    EndPoints,
}

/// Options for the size of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SizeOptions {
    /// The largest distance between patch and mesh, in model units.
    ///
    /// No patch keeps a tolerance below the sagitta of the facets, about h² κ / 8 for edge length h.
    pub tolerance: f64,
    /// Where the tolerance is tested.
    pub test: ErrorTest,
    /// Number of angles of the full test; at least 4.
    pub test_angles: u32,
    /// Whether a patch may extend beyond the boundary of the mesh. Test points there are ignored.
    pub overhang: bool,
    /// The largest turning angle |κᵢ Lᵢ| of an arc, in radians; below π/2.
    pub max_turn: f64,
    /// The largest radius, in model units. `None` means the diagonal of the bounding box of the mesh.
    pub max_radius: Option<f64>,
    /// The ratio of successive radii in the search; above 1.001.
    pub growth: f64,
    /// Number of bisections between the largest admissible radius and the next one.
    pub bisections: u32,
}

impl SizeOptions {
    /// Defaults for a tolerance: the full test at 16 angles, no overhang, turning angles up to 1.2 radians,
    /// radii in ratios of 1.25 with 5 bisections.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            test: ErrorTest::Full,
            test_angles: TEST_ANGLES,
            overhang: false,
            max_turn: 1.2,
            max_radius: None,
            growth: 1.25,
            bisections: 5,
        }
    }

    /// Checks the range of every option.
    pub(crate) fn check(&self) -> Result<(), OptionError> {
        let max_radius = self.max_radius.unwrap_or(1.0);
        let max_turn = core::f64::consts::FRAC_PI_2;
        let rules = [
            ("the tolerance", self.tolerance, 0.0, f64::INFINITY),
            ("the number of test angles", f64::from(self.test_angles), 3.0, 1e6),
            ("the largest turn", self.max_turn, 0.0, max_turn),
            ("the largest radius", max_radius, 0.0, f64::INFINITY),
            ("the growth of the radius", self.growth, 1.001, 100.0),
        ];
        for (what, value, above, below) in rules {
            if !(value > above && value < below) {
                return Err(OptionError { what, value, above, below });
            }
        }
        Ok(())
    }
}

/// An option out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value}, but it must be above {above} and below {below}")]
pub struct OptionError {
    /// Which option.
    pub what: &'static str,
    /// Its value.
    pub value: f64,
    /// The lower end of the range.
    pub above: f64,
    /// The upper end of the range.
    pub below: f64,
}
