//! One job of ours, in a process of its own, with the arguments and the answer of a driver.

use std::ops::ControlFlow;
use std::path::PathBuf;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};
use xtask_common::Failure;

use super::environment::Answer;
use crate::raw_mesh::RawMesh;
use crate::timing::least;

/// One job of ours; `flips` and `distances` start this program again with it.
#[derive(Debug, clap::Args)]
pub(crate) struct RivalJob {
    /// `proved`, `sampled` or a cost of flips
    method: String,
    /// The tolerance, the number of points, or a dash
    value: String,
    repeats: usize,
    first: PathBuf,
    second: PathBuf,
}

/// Does the job and prints its answer.
pub(crate) fn run(job: &RivalJob) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()
        .map_err(Failure::mesh)?;
    let answer = match job.method.as_str() {
        "proved" => {
            let options = CertifyOptions { tolerance: job.number()?, ..CertifyOptions::default() };
            job.distance(|a, b| {
                let bounds = hausdorff_bounds(a, b, &options);
                [Some(bounds.lower), Some(bounds.upper)]
            })?
        }
        "sampled" => {
            let samples = job.number()?;
            let options = CompareOptions { samples, ..CompareOptions::default() };
            job.distance(|a, b| [Some(compare(a, b, &options).hausdorff()), None])?
        }
        cost => {
            let cost =
                cost.parse().map_err(|e: dtri_flip::UnknownCost| Failure::Usage(e.to_string()))?;
            job.flip(cost)?
        }
    };
    println!("{answer}");
    Ok(())
}

impl RivalJob {
    fn number<T: std::str::FromStr>(&self) -> Result<T, Failure> {
        let unreadable =
            |_| Failure::Usage(format!("{} is no value for {}", self.value, self.method));
        self.value.parse().map_err(unreadable)
    }

    /// The time includes the trees over the faces of both meshes.
    fn distance(
        &self,
        compute: impl Fn(&Surface, &Surface) -> [Option<f64>; 2],
    ) -> Result<Answer, Failure> {
        let [a, b] = [&self.first, &self.second].map(|path| RawMesh::read(path));
        let (a, b) = (a?, b?);
        let (results, cost) = least(self.repeats, || {
            let surface = |raw: &RawMesh| {
                Surface::from_triangles(&raw.vertices, &raw.triangles).map_err(Failure::mesh)
            };
            Ok(compute(&surface(&a)?, &surface(&b)?))
        })?;
        Ok(Answer { cost, results: results.to_vec() })
    }

    fn flip(&self, cost: CostName) -> Result<Answer, Failure> {
        let mesh = RawMesh::read(&self.first)?.to_mesh()?;
        let options = FlipOptions::default();
        let (mut mesh, cost) = least(self.repeats, || {
            let mut mesh = mesh.clone();
            let goes_on = &mut |_| ControlFlow::Continue(());
            cost.optimise(&mut mesh, VertexArea::default(), &options, goes_on)
                .map_err(Failure::mesh)?;
            Ok(mesh)
        })?;
        mesh.compact();
        RawMesh::of(&mesh).write(&self.second)?;
        Ok(Answer { cost, results: Vec::new() })
    }
}
