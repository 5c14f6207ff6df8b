//! The one record of a run of `benches peers`: JSON lines, one for each job.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::errors::Errors;
use super::validity::Validity;
use crate::machine::Machine;

/// A job and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// The name of tool and preset on the command line.
    pub(super) name: String,
    /// The program or library.
    pub(super) tool: String,
    /// Its version, if it can be had.
    pub(super) version: Option<String>,
    pub(super) preset: String,
    pub(super) mesh: String,
    /// The class of the mesh, if the list of meshes has it.
    #[serde(default)]
    pub(super) class: Option<String>,
    /// Of the file of the mesh, in hexadecimal digits.
    pub(super) sha256: String,
    pub(super) input_faces: usize,
    pub(super) target: String,
    /// The number of faces that was asked for; none at an error limit.
    pub(super) wanted: Option<usize>,
    pub(super) threads: usize,
    pub(super) repeats: usize,
    /// Of the points at which distances are measured.
    pub(super) seed: u64,
    pub(super) machine: Machine,
    /// How many programs wanted to work, on average over the minute before the job, if the system reports it.
    #[serde(default)]
    pub(super) load: Option<f64>,
    /// None if the job failed.
    pub(super) outcome: Option<Outcome>,
    /// Why the job failed.
    pub(super) failure: Option<String>,
}

/// What a job left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Outcome {
    pub(super) faces: usize,
    /// The least time of the repeats.
    pub(super) seconds: f64,
    /// The time that cores worked, the least of the repeats, if the system reports it.
    #[serde(default)]
    pub(super) cpu_seconds: Option<f64>,
    /// Bytes beyond the memory in use after reading the input, if the system reports them.
    pub(super) memory: Option<u64>,
    /// In units of the diagonal.
    pub(super) errors: Errors,
    pub(super) validity: Validity,
}

/// Results whose face counts differ by more are not compared.
const LEEWAY: f64 = 0.02;
/// Results whose face counts differ by more have missed the number of faces.
const MISSED: f64 = 0.01;

/// Distances below this share of the diagonal count as equal: inputs are rounded to single precision, in which `Open3D`
/// measures.
const RESOLUTION: f64 = 1e-6;

impl Record {
    /// Whether the number of faces differs from the number that was asked for by no more than a limit.
    fn is_within(&self, limit: impl Fn(f64) -> f64) -> bool {
        match (&self.outcome, self.wanted) {
            (Some(outcome), Some(wanted)) => {
                outcome.faces.abs_diff(wanted) as f64 <= limit(wanted as f64)
            }
            (Some(_), None) => true,
            (None, _) => false,
        }
    }

    /// Whether errors and time can be compared with other tools.
    pub(super) fn is_comparable(&self) -> bool {
        self.is_within(|wanted| LEEWAY * wanted + 2.0)
    }

    /// Whether the job ended with another number of faces. One collapse more or less is none.
    pub(super) fn has_missed(&self) -> bool {
        self.outcome.is_some() && !self.is_within(|wanted| (MISSED * wanted).max(2.0))
    }

    /// Whether the result has defects that the input did not have.
    pub(super) fn has_new_defects(&self) -> bool {
        let has = |outcome: Outcome| outcome.validity.new_defects().iter().any(|(_, n)| *n > 0);
        self.outcome.is_some_and(has)
    }

    /// Whether it is the run of a tool on a file to a target.
    pub(super) fn is_run(&self, sha256: &str, target: &str, name: &str) -> bool {
        self.sha256 == sha256 && self.target == target && self.name == name
    }

    /// Whether it is a preset of ours.
    pub(super) fn is_ours(&self) -> bool {
        self.tool == "curvmesh"
    }

    /// Whether [`Record::time`] is the time of a core.
    pub(super) fn is_told_by_cores(&self) -> bool {
        self.threads == 1 && self.outcome.is_some_and(|outcome| outcome.cpu_seconds.is_some())
    }

    /// The time of a job of one thread: of its core if that is known, so that other work on the machine counts little.
    pub(super) fn time(&self) -> Option<f64> {
        let Outcome { seconds, cpu_seconds, .. } = self.outcome?;
        Some(cpu_seconds.filter(|_| self.threads == 1).unwrap_or(seconds))
    }

    /// Time, mean, root mean square and maximum of the distance, normals, and faces.
    pub(super) fn values(&self) -> Option<[f64; 6]> {
        let Outcome { faces, errors, .. } = self.outcome?;
        let Errors { mean, rms, max, normals } = errors;
        let [mean, rms, max] = [mean, rms, max].map(|distance| distance.max(RESOLUTION));
        Some([self.time()?, mean, rms, max, normals, faces as f64])
    }

    /// Memory for each face of the input.
    pub(super) fn bytes_per_face(&self) -> Option<f64> {
        Some(self.outcome?.memory? as f64 / self.input_faces.max(1) as f64)
    }
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:24} {:>12} {:20} ", self.mesh, self.target, self.name)?;
        let (Some(Outcome { faces, errors, validity, .. }), Some(seconds)) =
            (&self.outcome, self.time())
        else {
            return f.write_str(self.failure.as_deref().unwrap_or("it failed"));
        };
        write!(
            f,
            "{faces:>8} faces {seconds:9.4} s  mean {:.5} rms {:.5} max {:.4} %  normals {:6.3}",
            100.0 * errors.mean,
            100.0 * errors.rms,
            100.0 * errors.max,
            errors.normals,
        )?;
        if let Some(bytes) = self.bytes_per_face() {
            write!(f, "  {bytes:.0} bytes a face")?;
        }
        for (name, count) in validity.new_defects().iter().filter(|(_, count)| *count > 0) {
            write!(f, "  {name}: {count}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::json_lines;
    use crate::peers::validity::Defects;

    /// A record of a mesh of a thousand faces.
    pub(in crate::peers) fn record(name: &str, faces: usize, seconds: f64, mean: f64) -> Record {
        let ours = ["draft", "fast", "default"].contains(&name);
        let errors = Errors { mean, rms: mean, max: mean, normals: 1.0 };
        let input = Defects { slivers: 2, ..Defects::default() };
        let output = Defects { slivers: 5, turned: 1, ..Defects::default() };
        let validity = Validity { input, output, area: -0.25, volume: Some(0.5) };
        Record {
            name: name.into(),
            tool: if ours { "curvmesh".into() } else { name.into() },
            version: Some("1.0".into()),
            preset: name.into(),
            mesh: "a".into(),
            class: Some("scan".into()),
            sha256: "00".into(),
            input_faces: 1000,
            target: "10 %".into(),
            wanted: Some(100),
            threads: 1,
            repeats: 1,
            seed: 1,
            machine: Machine { cores: 2, cpu: None },
            load: Some(0.5),
            outcome: Some(Outcome {
                faces,
                seconds,
                cpu_seconds: None,
                memory: Some(5000),
                errors,
                validity,
            }),
            failure: None,
        }
    }

    #[test]
    fn records_survive_the_way_through_the_file() {
        let done = record("fast", 100, 0.5, 0.25);
        let failed = Record { outcome: None, failure: Some("why".into()), ..done.clone() };
        let records = [done, failed];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        json_lines::write(&records, &path).unwrap();
        assert_eq!(json_lines::read::<Record>(&path).unwrap(), records);
        let lines = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{lines}{{}}\n")).unwrap();
        assert!(json_lines::read::<Record>(&path).unwrap_err().to_string().contains("line 3"));
    }

    /// So that a record can be continued.
    #[test]
    fn a_run_is_of_a_tool_on_a_file_to_a_target() {
        let row = record("fast", 100, 1.0, 1.0);
        assert!(row.is_run("00", "10 %", "fast"));
        for (sha256, target, name) in
            [("01", "10 %", "fast"), ("00", "2 %", "fast"), ("00", "10 %", "draft")]
        {
            assert!(!row.is_run(sha256, target, name), "{sha256} {target} {name}");
        }
    }

    #[test]
    fn the_time_of_one_thread_is_the_time_of_its_core() {
        let mut job = record("fast", 100, 0.5, 0.25);
        assert_eq!(job.time(), Some(0.5));
        job.outcome.as_mut().unwrap().cpu_seconds = Some(0.25);
        assert_eq!(job.time(), Some(0.25));
        job.threads = 2;
        assert_eq!(job.time(), Some(0.5));
    }

    #[test]
    fn distances_below_the_resolution_are_equal() {
        let [a, b] = [1e-9, 1e-8].map(|mean| record("fast", 100, 0.5, mean).values());
        assert_eq!(a, b);
        assert_ne!(a, record("fast", 100, 0.5, 1e-5).values());
    }

    #[test]
    fn a_number_of_faces_is_missed_beyond_one_percent() {
        let missed = |faces: usize| {
            let mut record = record("fast", faces, 1.0, 1.0);
            record.wanted = Some(1000);
            record.has_missed()
        };
        assert_eq!([989, 990, 1010, 1011].map(missed), [true, false, false, true]);
    }
}
