//! `curvmesh lod --memory`: levels of detail of a mesh that does not fit into memory, region by region.

use serde::Serialize;

use crate::args::is_standard;
use crate::carry::{OF_ATTRIBUTES, ONLY_SHAPES};
use crate::commands::lod::options::Lod;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::large::{self, Level, Passes, RegionSettings};
use crate::load::Seconds;
use crate::save::{SAVE_OPTIONS, check_target, paths_of_levels};
use crate::session::{Outcome, Session};
use crate::simplify_options::{NOT_FITTED, OF_FITS};
use crate::task::Report;

#[derive(Serialize)]
struct Results {
    preset: String,
    #[serde(flatten)]
    in_force: RegionSettings,
    levels: Vec<Level>,
    passes: Passes,
}

pub(crate) fn run(options: &Lod, session: &Session) -> Result<Outcome, Failure> {
    check_given(options, &session.given)?;
    let Lod { source, output, steps, policy, large, save, .. } = options;
    let console = &session.console;
    let tiles = options.tiles;
    let steps = steps.or_default(None, console);
    let mut paths = paths_of_levels(&source.input, output, steps.count(), save, "ply");
    if tiles {
        paths = paths.iter().map(|path| path.with_extension("")).collect();
    }
    if !tiles {
        paths.iter().try_for_each(|path| check_target(path, save, &session.given))?;
    }
    let mut finer = large::levels(&steps.levels, &steps.faces);
    let chosen = policy.regional_options(finer.pop().unwrap_or_default())?.for_levels();
    let memory = large.memory.unwrap_or(u64::MAX);
    let prove = policy.proves().then_some(large::PROVED);
    let settings = large::settings(chosen, finer, memory, &source.loading.repair, prove)?;
    let in_force = RegionSettings::of(&settings);
    let takes_regions = tiles || paths.iter().all(|path| large::takes_regions(path, save));
    let mut seconds = Seconds::default();
    let (outcome, work) = Seconds::time(&mut seconds.compute, || {
        let folder = large::Folder { path: large.folder(output), resume: options.resume };
        large::simplify_file(
            &source.input,
            large,
            &folder,
            &source.loading,
            settings,
            takes_regions,
            console,
        )
    })?;
    let passes = Passes::of(&outcome);
    let levels = Seconds::time(&mut seconds.save, || {
        if tiles {
            large::save_tiles(&outcome, &work, &paths)
        } else {
            large::save_levels(&outcome, &work, &paths, save, console)
        }
    })?;
    let summary = &work.manifest().summary;
    let counts = [summary.vertices as usize, summary.triangles as usize];
    large::remove(work, large);
    let results = Results { preset: policy.preset.to_string(), in_force, levels, passes };
    let report = Report::new(console, &source.input, counts, results, seconds).with_output(output);
    let lines = report.results.levels.iter().map(|level| format!("\n  {level}"));
    let text = format!(
        "{}: {}{}",
        report.subject(),
        counted(report.faces, "faces"),
        lines.collect::<String>()
    );
    report.done(console, text, String::new())?.print(console)?;
    Ok(Outcome::of_run())
}

/// Refuses options that need the whole mesh in memory, and options that have no effect.
fn check_given(options: &Lod, given: &Given) -> Result<(), Failure> {
    given.refuse(&OF_FITS, NOT_FITTED)?;
    let of_wholes = [
        (!options.steps.errors.is_empty(), "--errors"),
        (options.record.is_some(), "--record"),
        (options.replay.is_some(), "--replay"),
        (options.look.is_wanted(), "--view"),
    ];
    if let Some((_, name)) = of_wholes.into_iter().find(|(is_given, _)| *is_given) {
        return Err(Failure::usage(format!(
            "{name} needs the whole mesh in memory, which --memory does not allow; allow more memory, or leave the option out"
        )));
    }
    given.refuse(&OF_ATTRIBUTES, ONLY_SHAPES)?;
    given.refuse(&["keep_seams"], ONLY_SHAPES)?;
    options.constraining.check_regional()?;
    if options.tiles {
        given.refuse(&SAVE_OPTIONS, "tiles are binary PLY files")?;
    }
    let output = &options.output;
    if is_standard(output) || !large::is_folder(output, &options.save, 2) {
        return Err(Failure::usage(format!(
            "{}: with --memory, levels go to a folder; name one",
            output.display()
        )));
    }
    Ok(())
}
