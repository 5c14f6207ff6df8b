//! One run of a tool, in a separate process.
//!
//! The process answers with one line: seconds, faces, the bytes it used beyond the input, and seconds of its cores.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use simplify::{ErrorCheck, Options, Preset, simplify};

use super::drivers::Driver;
use super::tool::Tool;
use crate::raw_mesh::RawMesh;
use crate::timing::{Cost, least};
use xtask_common::Failure;

/// The target of a simplification, for any mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Target {
    /// At a share of the faces.
    Share(f64),
    /// At a largest error relative to the diagonal.
    Error(f64),
}

/// The target of a simplification of one mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stop {
    Faces(usize),
    /// At a distance. The diagonal is one.
    Error(f64),
}

/// A tool and its task.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub(super) tool: Tool,
    pub(super) target: Stop,
    pub(super) threads: usize,
    pub(super) repeats: usize,
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
}

/// The outcome of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Done {
    pub(super) faces: usize,
    pub(super) cost: Cost,
}

impl Target {
    pub(super) fn of(self, mesh: &RawMesh) -> Stop {
        match self {
            Self::Share(share) => Stop::Faces((mesh.triangles.len() as f64 * share) as usize),
            Self::Error(share) => Stop::Error(share),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Share(share) => write!(f, "{} %", 100.0 * share),
            Self::Error(share) => write!(f, "within {} %", 100.0 * share),
        }
    }
}

impl Stop {
    /// As two arguments of a program.
    pub(super) fn arguments(self) -> [String; 2] {
        match self {
            Self::Faces(faces) => ["faces".into(), faces.to_string()],
            Self::Error(distance) => ["error".into(), distance.to_string()],
        }
    }
}

impl FromStr for Done {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.lines().last().unwrap_or_default().split_whitespace().collect();
        let found = match words[..] {
            [seconds, faces, peak, cpu] => {
                seconds.parse().ok().zip(faces.parse().ok()).map(|(seconds, faces)| {
                    let cost = Cost { seconds, cpu: cpu.parse().ok(), peak: peak.parse().ok() };
                    Self { faces, cost }
                })
            }
            _ => None,
        };
        found.ok_or_else(|| format!("no answer but {text:?}"))
    }
}

impl fmt::Display for Done {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fn told<T: ToString>(known: Option<T>) -> String {
            known.map_or_else(|| "-".to_owned(), |value| value.to_string())
        }
        let Self { faces, cost: Cost { seconds, cpu, peak } } = self;
        write!(f, "{seconds} {faces} {} {}", told(*peak), told(*cpu))
    }
}

/// One run of a preset or of meshoptimizer; `peers` starts this program again with it.
#[derive(Debug, clap::Args)]
pub(crate) struct PeerJob {
    tool: String,
    /// `faces` or `error`
    kind: String,
    value: f64,
    threads: usize,
    repeats: usize,
    input: PathBuf,
    output: PathBuf,
}

/// Does the run and prints its line.
pub(crate) fn run(options: &PeerJob) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .use_current_thread()
        .build_global()
        .map_err(Failure::mesh)?;
    let input = RawMesh::read(&options.input)?;
    let stop = match options.kind.as_str() {
        "faces" => Stop::Faces(options.value as usize),
        _ => Stop::Error(options.value),
    };
    let done = match Driver::of_name(&options.tool) {
        Some(_) => meshoptimizer(&input, stop, options)?,
        None => preset(&input, stop, options)?,
    };
    println!("{done}");
    Ok(())
}

fn preset(input: &RawMesh, stop: Stop, run: &PeerJob) -> Result<Done, Failure> {
    let (name, check) = match run.tool.strip_suffix("-proved") {
        Some(name) => (name, ErrorCheck::Certified),
        None => (run.tool.as_str(), ErrorCheck::Sampled),
    };
    let preset: Preset =
        name.parse().map_err(|e: simplify::UnknownPreset| Failure::Usage(e.to_string()))?;
    let options = match stop {
        Stop::Faces(faces) => Options::preset(preset).to_faces(faces),
        Stop::Error(distance) => Options::preset(preset).within(distance, check),
    };
    let mesh = input.to_mesh()?;
    let (result, cost) = least(run.repeats, || simplify(&mesh, &options).map_err(Failure::mesh))?;
    let mut mesh = result.mesh;
    mesh.compact();
    RawMesh::of(&mesh).write(&run.output)?;
    Ok(Done { faces: mesh.topology().face_count(), cost })
}

#[cfg(feature = "meshopt")]
fn meshoptimizer(input: &RawMesh, stop: Stop, run: &PeerJob) -> Result<Done, Failure> {
    use meshopt::{SimplifyOptions, VertexDataAdapter, typed_to_bytes};

    let Stop::Faces(faces) = stop else {
        return Err(Failure::Usage("meshoptimizer is asked for face counts only".into()));
    };
    let positions: Vec<[f32; 3]> = input.vertices.iter().map(|v| v.as_vec3().to_array()).collect();
    let vertices = VertexDataAdapter::new(typed_to_bytes(&positions), 12, 0)
        .map_err(|e| Failure::Usage(e.to_string()))?;
    let indices = input.triangles.as_flattened();
    let flags = match run.tool.as_str() {
        "meshoptimizer-permissive" => SimplifyOptions::Permissive,
        _ => SimplifyOptions::None,
    };
    // The weight of normals that the documentation of the library has.
    const WEIGHT: f32 = 0.5;
    let normals = (run.tool == "meshoptimizer-normals").then(|| input.vertex_normals());
    let unlocked = vec![false; positions.len()];
    let (count, limit) = (3 * faces, f32::MAX);
    let (result, cost) = least(run.repeats, || {
        Ok(match &normals {
            None => meshopt::simplify(indices, &vertices, count, limit, flags, None),
            Some(normals) => meshopt::simplify_with_attributes_and_locks(
                indices,
                &vertices,
                normals.as_flattened(),
                &[WEIGHT; 3],
                size_of::<[f32; 3]>(),
                &unlocked,
                count,
                limit,
                flags,
                None,
            ),
        })
    })?;
    let triangles: Vec<[u32; 3]> = result.as_chunks().0.to_vec();
    let faces = triangles.len();
    RawMesh { vertices: input.vertices.clone(), triangles }.write(&run.output)?;
    Ok(Done { faces, cost })
}

#[cfg(not(feature = "meshopt"))]
fn meshoptimizer(_: &RawMesh, _: Stop, _: &PeerJob) -> Result<Done, Failure> {
    Err(Failure::Usage("this program was built without the feature meshopt".into()))
}

#[cfg(test)]
mod tests {
    use super::{Cost, Done};

    #[test]
    fn an_answer_survives_the_way_through_the_text() {
        for (peak, cpu) in [(None, None), (Some(7), None), (None, Some(0.125))] {
            let done = Done { faces: 3, cost: Cost { seconds: 0.25, cpu, peak } };
            assert_eq!(format!("noise\n{done}\n").parse(), Ok(done));
        }
        assert!("nothing".parse::<Done>().is_err());
    }
}
