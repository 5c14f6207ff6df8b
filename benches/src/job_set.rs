//! Sets of jobs as data: `benches/jobs.toml`.

use std::collections::BTreeMap;

use serde::Deserialize;

use xtask_common::Failure;

/// Which meshes are simplified how far, by which tools.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct JobSet {
    /// File names.
    pub(crate) meshes: Vec<String>,
    /// Shares of the faces.
    #[serde(default)]
    pub(crate) ratios: Vec<f64>,
    /// Largest errors in percent of the diagonal.
    #[serde(default)]
    pub(crate) max_errors: Vec<f64>,
    pub(crate) tools: Vec<String>,
    /// Runs whose least time counts.
    pub(crate) repeats: usize,
}

/// The sets that are part of this program.
const SETS: &str = include_str!("../jobs.toml");

impl JobSet {
    /// The set of a name.
    pub(crate) fn of_name(name: &str) -> Result<Self, Failure> {
        let mut sets = Self::all()?;
        sets.remove(name).ok_or_else(|| {
            let names: Vec<String> = sets.into_keys().collect();
            Failure::Usage(format!("there are no jobs `{name}`; there are {}", names.join(", ")))
        })
    }

    fn all() -> Result<BTreeMap<String, Self>, Failure> {
        toml::from_str(SETS).map_err(Failure::numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::is_tool;

    #[test]
    fn every_set_can_be_run() {
        let sets = JobSet::all().unwrap();
        assert!(sets.len() >= 5);
        for (name, set) in sets {
            assert!(!set.meshes.is_empty() && !set.tools.is_empty() && set.repeats > 0, "{name}");
            // One kind of target.
            assert!(set.ratios.is_empty() != set.max_errors.is_empty(), "{name}");
            assert!(set.ratios.iter().all(|share| (0.0..1.0).contains(share)), "{name}");
            for tool in &set.tools {
                assert!(is_tool(tool, !set.max_errors.is_empty()), "{name}: {tool}");
            }
        }
        assert!(JobSet::of_name("none").unwrap_err().to_string().contains("short"));
    }

    #[test]
    fn anyone_can_have_the_meshes_of_all_sets() {
        for (name, set) in JobSet::all().unwrap() {
            for mesh in set.meshes {
                assert!(crate::fetch::has(&mesh).unwrap(), "{name}: {mesh}");
            }
        }
    }
}
