//! Sets of jobs as data: `benches/rivals.toml`.

use std::collections::BTreeMap;

use serde::Deserialize;
use xtask_common::Failure;

/// Which meshes are flipped by which tools.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FlipSet {
    pub(super) meshes: Vec<String>,
    pub(super) tools: Vec<String>,
    /// Runs whose least time counts.
    pub(super) repeats: usize,
    /// Jobs that take longer are ended.
    pub(super) limit_seconds: u64,
}

/// Between which meshes distances are computed, how closely, by which tools.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DistanceSet {
    /// Meshes that are compared with simplified versions of themselves.
    pub(super) meshes: Vec<String>,
    /// Faces of the versions, as shares.
    pub(super) ratios: Vec<f64>,
    /// Pairs of different meshes.
    pub(super) different: Vec<[String; 2]>,
    /// Largest differences between the bounds, as shares of the diagonal.
    pub(super) tolerances: Vec<f64>,
    /// Points in each direction, for the tools that sample.
    pub(super) samples: u32,
    pub(super) tools: Vec<String>,
    pub(super) repeats: usize,
    pub(super) limit_seconds: u64,
}

/// All sets.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sets {
    pub(super) flips: BTreeMap<String, FlipSet>,
    pub(super) distances: BTreeMap<String, DistanceSet>,
}

impl Sets {
    /// The sets that are part of this program.
    pub(super) fn read() -> Result<Self, Failure> {
        toml::from_str(include_str!("../../rivals.toml")).map_err(Failure::numbers)
    }
}

/// The set of a name.
pub(super) fn of_name<S>(mut sets: BTreeMap<String, S>, name: &str) -> Result<S, Failure> {
    sets.remove(name).ok_or_else(|| {
        let names: Vec<String> = sets.into_keys().collect();
        Failure::Usage(format!("there are no jobs `{name}`; there are {}", names.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::source::Source;
    use crate::rivals::tool::{Kind, Tool};

    #[test]
    fn every_set_can_be_run() {
        let Sets { flips, distances } = Sets::read().unwrap();
        for set in flips.into_values() {
            assert!(set.repeats > 0 && !set.meshes.is_empty() && set.limit_seconds > 0);
            assert!(!Tool::chosen(Kind::Flips, &set.tools).unwrap().is_empty());
            anyone_can_have(&set.meshes);
        }
        for set in distances.into_values() {
            assert!(set.repeats > 0 && set.samples > 0 && set.limit_seconds > 0);
            assert!(set.tolerances.iter().all(|&tolerance| tolerance > 0.0));
            assert!(set.ratios.iter().all(|ratio| (0.0..1.0).contains(ratio)));
            assert!(!Tool::chosen(Kind::Distances, &set.tools).unwrap().is_empty());
            anyone_can_have(&set.meshes);
            anyone_can_have(set.different.as_flattened());
        }
        let error = of_name(Sets::read().unwrap().flips, "none").unwrap_err().to_string();
        assert!(error.contains("full, growth, tiny"), "{error}");
    }

    fn anyone_can_have(meshes: &[String]) {
        for mesh in meshes {
            let is_file = matches!(Source::of_name(mesh), Source::File(_));
            assert!(!is_file || crate::fetch::has(mesh).unwrap(), "{mesh}");
        }
    }
}
