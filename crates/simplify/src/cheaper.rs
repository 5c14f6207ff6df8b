//! Which cheaper preset is tried beside a careful one.
//!
//! Presets collapse in different orders. If few faces are left, chance decides which order ends closer to the input,
//! and no refinement makes up for that. So where it takes little time, a preset also makes the result of the next
//! cheaper preset, and keeps the one with the smaller mean distance.

use core::ops::ControlFlow;

use mesh_collapse::{Progress, StopReason};
use mesh_core::TriMesh;
use mesh_metric::Surface;
use mesh_refine::mean_distance;

use crate::after_collapses::SMALL;
use crate::error::SimplifyError;
use crate::options::{Options, RefineOptions};
use crate::preset::Preset;
use crate::run::run_plan;
use crate::simplified::Simplified;

/// Presets, each with the next cheaper one.
const CHEAPER: [(Preset, Preset); 4] = [
    (Preset::Fast, Preset::Draft),
    (Preset::Default, Preset::Fast),
    (Preset::Quality, Preset::Default),
    (Preset::Extreme, Preset::Quality),
];

/// The largest numbers of faces of input and result for which presets are tried that take longer than the default.
const MOST_FACES: usize = 100_000;
const MOST_LEFT: usize = 1_000;

/// The factor of a mean beside that of a cheaper preset from which the result of the cheaper one is kept. Below it,
/// lower largest errors count more.
const MORE: f64 = 1.01;

/// The numbers of points at which means are compared: for quick presets and for others.
const FEW_POINTS: usize = 8_000;
const MANY_POINTS: usize = 40_000;

/// Simplifies a mesh by the options, and also by the cheaper presets where that takes little time. The result of a
/// cheaper preset stays if its mean distance is smaller by more than a percent. A run that the observer stops returns
/// the result of the options themselves.
pub(crate) fn closest(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let faces = mesh.topology().face_count();
    let cheaper = cheaper(options, faces);
    let mut found = run_plan(mesh, options, observe)?;
    let Some((preset, options)) = cheaper else { return Ok(found) };
    let has_faces = |result: &Simplified| result.mesh.topology().face_count() > 0;
    if found.stop == StopReason::Cancelled || found.collapses == 0 || !has_faces(&found) {
        return Ok(found);
    }
    let mut other = closest(mesh, &options, observe)?;
    if other.stop == StopReason::Cancelled {
        found.stop = StopReason::Cancelled;
        return Ok(found);
    }
    let most = found.mesh.topology().face_count().max(options.target.face_target(faces));
    if has_faces(&other) && other.mesh.topology().face_count() <= most {
        let original = Surface::new(mesh)?;
        let points =
            if matches!(preset, Preset::Draft | Preset::Fast) { FEW_POINTS } else { MANY_POINTS };
        let mean = |of: &Simplified| mean_distance(&original, &of.mesh, points);
        let [own, others] = [mean(&found)?, mean(&other)?];
        if own > MORE * others {
            other.preset_kept = other.preset_kept.or(Some(preset));
            return Ok(other);
        }
    }
    Ok(found)
}

/// The options with the method of the next cheaper preset, if they belong to a preset and the mesh is small enough.
/// Targets, protection and attributes are the same. With poses, the mean distance in one of them does not count.
fn cheaper(options: &Options, faces: usize) -> Option<(Preset, Options)> {
    let has_poses = options.attributes.poses.is_some();
    if !options.counts_mean() || has_poses || options.target.time.is_some() {
        return None;
    }
    let with_method_of = |preset: Preset| {
        let Options { cost, placement, refine, .. } = Options::preset(preset);
        let RefineOptions { norm, seed, .. } = options.refine;
        let refine = RefineOptions { norm, seed, ..refine };
        Options { cost, placement, refine, ..options.clone() }
    };
    let is_method_of = |preset: Preset| {
        let Options { cost, placement, refine, .. } = with_method_of(preset);
        (cost, placement, refine) == (options.cost, options.placement, options.refine)
    };
    let (careful, cheap) = CHEAPER.into_iter().find(|&(careful, _)| is_method_of(careful))?;
    let left = options.target.face_target(faces);
    let is_slow = matches!(careful, Preset::Quality | Preset::Extreme);
    let is_worth_it = faces <= SMALL || (is_slow && faces <= MOST_FACES && left <= MOST_LEFT);
    is_worth_it.then(|| (cheap, with_method_of(cheap)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::measure::ErrorCheck;
    use mesh_refine::FitNorm;

    #[test]
    fn a_preset_tries_the_next_cheaper_one_where_that_takes_little_time() {
        let tried = |preset, faces: usize, left: usize| {
            let options = Options::preset(preset).to_faces(left);
            cheaper(&options, faces).map(|(preset, _)| preset)
        };
        assert_eq!(tried(Preset::Default, SMALL, 900), Some(Preset::Fast));
        assert_eq!(tried(Preset::Default, SMALL + 1, 900), None);
        assert_eq!(tried(Preset::Quality, MOST_FACES, MOST_LEFT), Some(Preset::Default));
        assert_eq!(tried(Preset::Quality, MOST_FACES, MOST_LEFT + 1), None);
        assert_eq!(tried(Preset::Extreme, MOST_FACES + 1, MOST_LEFT), None);
        assert_eq!(tried(Preset::Extreme, SMALL, 2_000), Some(Preset::Quality));
        assert_eq!(tried(Preset::Fast, SMALL, 50), Some(Preset::Draft));
        assert_eq!(tried(Preset::Fast, SMALL + 1, 50), None);
        assert_eq!(tried(Preset::Draft, 100, 50), None);
    }

    #[test]
    fn other_costs_and_aims_have_no_cheaper_preset() {
        let usual = Options::default().to_faces(50);
        let is_tried = |change: &dyn Fn(&mut Options)| {
            let mut options = usual.clone();
            change(&mut options);
            cheaper(&options, 100).is_some()
        };
        assert!(is_tried(&|_| {}));
        assert!(is_tried(&|options| options.refine.seed = 7));
        assert!(is_tried(&|options| options.refine.norm = FitNorm::L1));
        assert!(!is_tried(&|options| options.refine.norm = FitNorm::Max));
        assert!(!is_tried(&|options| options.cost.curvature_weight = 0.5));
        assert!(!is_tried(&|options| options.refine.fit = false));
        assert!(!is_tried(&|options| options.target.time = Some(core::time::Duration::MAX)));
        assert!(!is_tried(&|options| *options = usual.clone().within(0.1, ErrorCheck::Sampled)));
        let seeded = Options { refine: RefineOptions { seed: 7, ..usual.refine }, ..usual.clone() };
        let (_, with) = cheaper(&seeded, 100).unwrap();
        assert_eq!((with.refine.seed, with.target.faces), (7, Some(50)));
    }
}
