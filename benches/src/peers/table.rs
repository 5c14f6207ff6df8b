//! The numbers of all runs, and their geometric means as ratios to one of the tools.

use std::fmt;
use std::fmt::Write as _;
use std::path::Path;

use super::errors::Errors;
use super::job::{Done, Target};
use super::raw::RawMesh;
use super::tool::Tool;
use xtask_common::Failure;

/// A run.
#[derive(Clone, Debug)]
pub(super) struct Row {
    mesh: String,
    faces: usize,
    target: String,
    tool: String,
    /// The requested number of faces, if any.
    wanted: Option<usize>,
    result: Result<(Done, Errors), String>,
}

/// Results whose face counts differ by more are not compared.
const LEEWAY: f64 = 0.02;

impl Row {
    pub(super) fn done(
        mesh: &str,
        raw: &RawMesh,
        target: Target,
        tool: &Tool,
        done: &Done,
        errors: &Errors,
    ) -> Self {
        Self {
            result: Ok((*done, *errors)),
            ..Self::failed(mesh, raw, target, tool, String::new())
        }
    }

    pub(super) fn failed(
        mesh: &str,
        raw: &RawMesh,
        target: Target,
        tool: &Tool,
        why: String,
    ) -> Self {
        let faces = raw.triangles.len();
        let wanted = match target {
            Target::Share(share) => Some((faces as f64 * share) as usize),
            Target::Error(_) => None,
        };
        let [target, tool] = [target.to_string(), tool.to_string()];
        Self { mesh: mesh.to_owned(), faces, target, tool, wanted, result: Err(why) }
    }

    /// Whether the run has the requested number of faces.
    fn is_comparable(&self) -> bool {
        match (&self.result, self.wanted) {
            (Ok((done, _)), Some(wanted)) => {
                done.faces.abs_diff(wanted) as f64 <= LEEWAY * wanted as f64 + 2.0
            }
            (Ok(_), None) => true,
            (Err(_), _) => false,
        }
    }

    /// Time, mean, root mean square and maximum of the distance, normals, and faces.
    fn values(&self) -> Option<[f64; 6]> {
        let (done, errors) = self.result.as_ref().ok()?;
        let Errors { mean, rms, max, normals } = *errors;
        Some([done.seconds, mean, rms, max, normals, done.faces as f64])
    }

    fn bytes_per_face(&self) -> Option<f64> {
        Some(self.result.as_ref().ok()?.0.peak? as f64 / self.faces.max(1) as f64)
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:24} {:>12} {:20} ", self.mesh, self.target, self.tool)?;
        match &self.result {
            Ok((done, errors)) => write!(
                f,
                "{:>8} faces {:9.4} s  mean {:.5} rms {:.5} max {:.4} %  normals {:6.3}{}",
                done.faces,
                done.seconds,
                100.0 * errors.mean,
                100.0 * errors.rms,
                100.0 * errors.max,
                errors.normals,
                self.bytes_per_face()
                    .map_or_else(String::new, |b| format!("  {b:.0} bytes a face")),
            ),
            Err(why) => f.write_str(why),
        }
    }
}

/// All runs, one per line.
pub(super) fn write_csv(rows: &[Row], path: &Path) -> Result<(), Failure> {
    let failed = |e: csv::Error| Failure::writing(path)(e);
    let mut table = csv::Writer::from_path(path).map_err(failed)?;
    let header = ["mesh", "faces", "target", "tool", "seconds", "mean", "rms", "max", "normals"];
    let more = ["faces_left", "bytes_per_face", "failure"];
    table.write_record(header.iter().chain(&more)).map_err(failed)?;
    for row in rows {
        let mut record =
            vec![row.mesh.clone(), row.faces.to_string(), row.target.clone(), row.tool.clone()];
        match row.values() {
            Some(values) => record.extend(values.map(|value| value.to_string())),
            None => record.extend([(); 6].map(|()| String::new())),
        }
        record.push(row.bytes_per_face().map_or_else(String::new, |bytes| format!("{bytes:.1}")));
        record.push(row.result.as_ref().err().cloned().unwrap_or_default());
        table.write_record(&record).map_err(failed)?;
    }
    table.flush().map_err(Failure::writing(path))
}

/// Geometric means of the ratios to the base: over all targets, and for each of them.
pub(super) fn markdown(
    rows: &[Row],
    tools: &[Tool],
    base: &Tool,
    targets: &[Target],
    threads: usize,
) -> String {
    let mut text = String::new();
    let all: Vec<String> = targets.iter().map(ToString::to_string).collect();
    let mut groups: Vec<(String, &[String])> = vec![(all.join(", "), &all)];
    if all.len() > 1 {
        groups.extend(all.iter().map(|target| (target.clone(), core::slice::from_ref(target))));
    }
    for (title, of) in groups {
        let _ = writeln!(text, "\n{title}, threads: {threads}; ratios to {base}\n");
        text.push_str(
            "| tool | runs | time | mean | rms | max | normals | faces | worst mean | most bytes a face |\n\
             |---|---|---|---|---|---|---|---|---|---|\n",
        );
        let rows: Vec<&Row> = rows.iter().filter(|row| of.contains(&row.target)).collect();
        for tool in tools {
            line(&mut text, &rows, &tool.to_string(), &base.to_string());
        }
    }
    text
}

fn line(text: &mut String, rows: &[&Row], tool: &str, base: &str) {
    let own: Vec<&&Row> = rows.iter().filter(|row| row.tool == tool).collect();
    let ratios: Vec<[f64; 6]> = own
        .iter()
        .filter(|row| row.is_comparable())
        .filter_map(|row| {
            let same = |other: &&&Row| {
                other.tool == base && (&other.mesh, &other.target) == (&row.mesh, &row.target)
            };
            let other = rows.iter().find(same).filter(|other| other.is_comparable())?;
            let (ours, theirs) = (row.values()?, other.values()?);
            Some(core::array::from_fn(|i| ours[i].max(1e-12) / theirs[i].max(1e-12)))
        })
        .collect();
    let mean =
        |i: usize| (ratios.iter().map(|r| r[i].ln()).sum::<f64>() / ratios.len() as f64).exp();
    let worst = ratios.iter().map(|r| r[1]).fold(f64::NAN, f64::max);
    let bytes = own.iter().filter_map(|row| row.bytes_per_face()).fold(f64::NAN, f64::max);
    let told = |x: f64, digits: usize| {
        if x.is_nan() { "–".to_owned() } else { format!("{x:.digits$}") }
    };
    let _ = writeln!(
        text,
        "| {tool} | {} of {} | {} | {} | {} |",
        ratios.len(),
        own.len(),
        core::array::from_fn::<_, 6, _>(|i| told(mean(i), 3)).join(" | "),
        told(worst, 2),
        told(bytes, 0),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use simplify::Preset;

    fn row(tool: &Tool, faces: usize, seconds: f64, mean: f64) -> Row {
        let raw = RawMesh { vertices: Vec::new(), triangles: vec![[0; 3]; 1000] };
        let errors = Errors { mean, rms: mean, max: mean, normals: 1.0 };
        let done = Done { seconds, faces, peak: Some(5000) };
        Row::done("a", &raw, Target::Share(0.1), tool, &done, &errors)
    }

    #[test]
    fn ratios_are_geometric_means_over_equal_counts() {
        let (fast, base) = (Tool::Ours(Preset::Fast), Tool::CgalLindstromTurk);
        let rows = [row(&fast, 100, 1.0, 3.0), row(&base, 101, 4.0, 2.0)];
        let tools = [fast.clone(), base.clone()];
        let text = markdown(&rows, &tools, &base, &[Target::Share(0.1)], 1);
        assert!(text.contains("| fast | 1 of 1 | 0.250 | 1.500 |"), "{text}");
        let missed = [row(&fast, 120, 1.0, 3.0), row(&base, 101, 4.0, 2.0)];
        let text = markdown(&missed, &tools, &base, &[Target::Share(0.1)], 1);
        assert!(text.contains("| fast | 0 of 1 |"), "{text}");
    }
}
