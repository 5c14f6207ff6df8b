//! Szilvási-Nagy 2010: face-based curvature, patches made from it, and what is said of them.

mod arcs;
mod cow;
mod disc;
mod drawing;
mod half_cylinder;
mod patches;
mod regions;
mod series;
mod sphere;
mod statistics;
mod translation;

use super::step::Step;

pub(super) const STEPS: [Step; 9] = [
    Step { name: "Fig. 1 to 3", data: &[], compute: disc::compute },
    Step { name: "Fig. 4 and 5", data: &[], compute: arcs::compute },
    Step { name: "Fig. 6", data: &[], compute: translation::compute },
    Step { name: "Fig. 7", data: &[], compute: half_cylinder::compute },
    Step { name: "Fig. 8", data: &[], compute: series::compute },
    Step { name: "Fig. 9 and 10", data: &[], compute: sphere::compute },
    Step { name: "Fig. 11 and 12", data: &[], compute: regions::compute },
    Step { name: "Fig. 13", data: &[], compute: cow::figure },
    Step { name: "Covers of whole meshes", data: &[], compute: cow::covers },
];
