//! Putting together the normal equations of a mesh, or of a part of it.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, parallel};
use mesh_metric::Surface;

use crate::finish::blocks::for_blocks_in_turn;
use crate::finish::fit::element::{Element, Tally, Weighting};
use crate::finish::fit::spread::{Spot, Spread};
use crate::finish::fit::system::System;
use crate::finish::fit::targets::Target;

/// What makes the equations of some faces, besides the targets that they draw.
pub(super) struct Equations<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) original: &'a Surface,
    /// All faces of the mesh.
    pub(super) faces: &'a [FaceId],
    /// The indices of those that count, neighbours in space close to each other.
    pub(super) order: &'a [u32],
    /// How many points of these faces are drawn to the original.
    pub(super) samples: usize,
    /// How much each counts.
    pub(super) density: f64,
    pub(super) seed: u64,
}

/// Faces whose equations are made by one thread at a time.
const BLOCK: usize = 64;

impl Equations<'_> {
    /// Adds the pairs of every face: the targets that it draws, and samples of its own with the
    /// closest points of the original.
    pub(super) fn add_to(
        &self,
        system: &mut System,
        weighting: Weighting,
        targets_of: impl Fn(FaceId, &mut dyn FnMut(&Target)) + Sync,
    ) -> Tally {
        let corners = |index: u32| self.mesh.triangle(self.faces[index as usize]);
        let spread = Spread::new(self.order, corners, self.samples, self.seed);
        let own_weighting = match weighting.tail > 0.0 {
            true => {
                Weighting { largest: self.farthest(&spread).max(weighting.largest), ..weighting }
            }
            false => weighting,
        };
        let mut tally = Tally::default();
        for_blocks_in_turn(
            self.order.len(),
            BLOCK,
            |places| {
                let start = places.start;
                let mut elements = vec![Element::default(); places.len()];
                let spots: Vec<Spot> = spread.spots(corners, spread.on(places.clone())).collect();
                let points: Vec<DVec3> = spots.iter().map(|spot| spot.point).collect();
                let closest = self.original.closest_to_neighbours(&points);
                for (spot, closest) in spots.iter().zip(closest) {
                    let share = self.density * spot.share;
                    let on = self.original.triangle(closest.triangle as usize);
                    let target = Target::on_triangle(on, closest.point, share);
                    let corners = corners(spot.triangle);
                    elements[spot.place - start].add(
                        &corners,
                        spot.weights,
                        &target,
                        &own_weighting,
                    );
                }
                for (place, element) in places.zip(&mut elements) {
                    let face = self.faces[self.order[place] as usize];
                    let corners = self.mesh.triangle(face);
                    targets_of(face, &mut |target| {
                        let weights = mesh_metric::weights_of_closest(target.point, &corners);
                        element.add(&corners, weights, target, &weighting);
                    });
                }
                (start, elements)
            },
            |(start, elements)| {
                for (&index, element) in self.order[start..].iter().zip(&elements) {
                    system.add(self.mesh, self.faces[index as usize], element);
                    tally.join(element.tally);
                }
            },
        );
        tally
    }

    /// The largest squared distance of a sample from the original.
    fn farthest(&self, spread: &Spread<'_>) -> f64 {
        const POINTS: usize = 1024;
        let corners = |index: u32| self.mesh.triangle(self.faces[index as usize]);
        let count = spread.len();
        let of_blocks = parallel::collect_with(
            count.div_ceil(POINTS),
            || (),
            |(), block| {
                let range = block * POINTS..count.min((block + 1) * POINTS);
                let points: Vec<DVec3> =
                    spread.spots(corners, range).map(|spot| spot.point).collect();
                let closest = self.original.closest_to_neighbours(&points);
                closest.iter().map(|closest| closest.offset.length_squared()).fold(0.0, f64::max)
            },
        );
        of_blocks.into_iter().fold(0.0, f64::max)
    }
}
