//! Dyn, Hormann, Kim, Levin 2001: edge flips by the curvature costs F1, F2, F3.

mod convex;
mod look_ahead;
mod models;
mod part;
mod seven_points;
mod subdivided;
mod thin_plate;
mod tie_orders;
mod tori;
pub(super) mod torus;

use super::step::Step;

pub(super) const STEPS: [Step; 9] = [
    Step {
        name: "Sec. 3, thin-plate energy",
        data: &["torus", "convex7"],
        compute: thin_plate::compute,
    },
    Step { name: "Sec. 4, convex data", data: &[], compute: convex::compute },
    Step { name: "Fig. 4", data: &["convex7"], compute: seven_points::compute },
    Step { name: "Table 1 and Fig. 5", data: &["torus"], compute: torus::compute },
    Step { name: "Table 1, order of ties", data: &["torus"], compute: tie_orders::compute },
    Step { name: "Sec. 4, many tori", data: &[], compute: tori::compute },
    Step { name: "Look-ahead on the torus", data: &["torus"], compute: look_ahead::compute },
    Step { name: "Fig. 6", data: &["torus"], compute: subdivided::compute },
    Step { name: "Fig. 7 to 9", data: &[], compute: models::compute },
];
