//! Time and memory of a call.

use std::time::Instant;

use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use xtask_common::Failure;

use crate::memory;

/// Time and memory of a job.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Cost {
    /// The minimum over the runs.
    pub(crate) seconds: f64,
    /// The time that cores worked for it, the minimum over the runs, if the system reports it.
    pub(crate) cpu: Option<f64>,
    /// Peak memory beyond the memory in use after reading the input, if the system reports it.
    pub(crate) peak: Option<u64>,
}

/// No further runs after this total time in seconds.
const ENOUGH: f64 = 10.0;

/// The last result of several runs, their minimum times, and the memory of the first one.
pub(crate) fn least<T>(
    repeats: usize,
    mut compute: impl FnMut() -> Result<T, Failure>,
) -> Result<(T, Cost), Failure> {
    let mut least = Cost { seconds: f64::INFINITY, cpu: None, peak: None };
    let mut sum = 0.0;
    let mut count = 0;
    loop {
        let before = memory::start();
        let worked = ProcessTime::try_now();
        let start = Instant::now();
        let result = compute()?;
        let seconds = start.elapsed().as_secs_f64();
        let cpu = worked.and_then(|worked| worked.try_elapsed()).ok();
        let cpu = cpu.map(|cpu| cpu.as_secs_f64());
        if count == 0 {
            least.peak = before.and_then(memory::beyond);
        }
        least.seconds = least.seconds.min(seconds);
        least.cpu = cpu.map(|cpu| least.cpu.map_or(cpu, |other| other.min(cpu)));
        sum += seconds;
        count += 1;
        if count >= repeats || sum > ENOUGH {
            return Ok((result, least));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::least;

    /// Waiting takes time, but no core works meanwhile. Cores may work for other tests of this process, so the wait is
    /// repeated until they are done.
    #[test]
    fn the_time_of_cores_is_without_waiting() {
        let wait = std::time::Duration::from_millis(50);
        let is_without = (0..400).any(|_| {
            let (_, cost) = least(1, || {
                std::thread::sleep(wait);
                Ok(())
            })
            .unwrap();
            assert!(cost.seconds >= wait.as_secs_f64());
            cost.cpu.is_some_and(|cpu| cpu < cost.seconds)
        });
        assert!(is_without);
    }
}
