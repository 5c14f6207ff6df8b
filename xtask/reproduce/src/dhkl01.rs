//! Dyn, Hormann, Kim, Levin 2001: edge flips by the curvature costs F1, F2, F3.

mod convex;
mod look_ahead;
mod models;
mod part;
mod seven_points;
mod subdivided;
mod tie_orders;
mod torus;

use super::step::Step;

pub(super) const STEPS: [Step; 7] = [
    Step { name: "Sec. 4, convex data", compute: convex::compute },
    Step { name: "Fig. 4", compute: seven_points::compute },
    Step { name: "Table 1 and Fig. 5", compute: torus::compute },
    Step { name: "Table 1, order of ties", compute: tie_orders::compute },
    Step { name: "Look-ahead on the torus", compute: look_ahead::compute },
    Step { name: "Fig. 6", compute: subdivided::compute },
    Step { name: "Fig. 7 to 9", compute: models::compute },
];
