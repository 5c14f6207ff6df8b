//! Time and memory of a computation.

use std::fmt;
use std::str::FromStr;

use cpu_time::ProcessTime;
use xtask_common::Failure;

use crate::memory;

/// What a computation needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    /// Seconds of processor time.
    pub(super) seconds: f64,
    /// Bytes beyond the mesh, if the system reports them.
    pub(super) peak: Option<u64>,
}

impl Cost {
    pub(super) const UNKNOWN: Self = Self { seconds: f64::NAN, peak: None };
}

impl FromStr for Cost {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let seconds = words.first().and_then(|word| word.parse().ok());
        let seconds = seconds.ok_or_else(|| format!("no seconds in {text:?}"))?;
        Ok(Self { seconds, peak: words.get(1).and_then(|word| word.parse().ok()) })
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let peak = self.peak.map_or_else(|| "-".to_owned(), |peak| peak.to_string());
        write!(f, "{} {peak}", self.seconds)
    }
}

/// A computation and its cost.
pub(super) fn measured<T>(
    compute: impl FnOnce() -> Result<T, Failure>,
) -> Result<(T, Cost), Failure> {
    let before = memory::start();
    let worked = ProcessTime::now();
    let found = compute()?;
    let seconds = worked.elapsed().as_secs_f64();
    Ok((found, Cost { seconds, peak: before.and_then(memory::beyond) }))
}

#[cfg(test)]
mod tests {
    use super::Cost;

    #[test]
    fn a_cost_survives_the_way_through_the_text() {
        for peak in [None, Some(7)] {
            let cost = Cost { seconds: 0.25, peak };
            assert_eq!(format!("{cost}\n").parse(), Ok(cost));
        }
        assert!("failed".parse::<Cost>().is_err());
    }
}
