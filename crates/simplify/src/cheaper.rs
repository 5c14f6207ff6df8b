//! Which cheaper preset is tried beside a careful one.
//!
//! Presets collapse in different orders. If few faces are left, chance decides which order ends closer to the input,
//! and no refinement makes up for that. So where it takes little time, a preset also makes the result of the next
//! cheaper preset, and keeps the one with the smaller mean distance.

use mesh_refine::FitNorm;

use crate::options::{Options, RefineOptions};
use crate::preset::Preset;

/// Careful presets, each with the next cheaper one.
const CHEAPER: [(Preset, Preset); 3] = [
    (Preset::Default, Preset::Fast),
    (Preset::Quality, Preset::Default),
    (Preset::Extreme, Preset::Quality),
];

/// The largest number of faces of an input on which every preset is tried, and every stage measured.
const SMALL: usize = 5_000;

/// The largest numbers of faces of input and result for which presets are tried that take longer than the default.
const MOST_FACES: usize = 100_000;
const MOST_LEFT: usize = 1_000;

/// Whether stages of refinement that raise the mean distance are undone. With an error limit, or a norm for the largest
/// distance, the mean does not count.
pub(crate) fn undoes_stages(options: &Options, faces: usize) -> bool {
    faces <= SMALL && counts_mean(options)
}

fn counts_mean(options: &Options) -> bool {
    options.tolerance.distance.is_none() && options.refine.norm != FitNorm::Max
}

/// The options with the method of the next cheaper preset, if they are those of a preset and the mesh is small enough.
/// Targets, protection and attributes are the same.
pub(crate) fn cheaper(options: &Options, faces: usize) -> Option<(Preset, Options)> {
    if !counts_mean(options) || options.target.time.is_some() {
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
    let is_worth_it =
        faces <= SMALL || (careful != Preset::Default && faces <= MOST_FACES && left <= MOST_LEFT);
    is_worth_it.then(|| (cheap, with_method_of(cheap)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::measure::ErrorCheck;

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
        assert_eq!(tried(Preset::Fast, 100, 50), None);
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
