//! The folder of a run: what is in it, and the steps from files to files.
//!
//! ```text
//! run.json                   the options, what is known of the input, the cells
//! level-0/cell-3.region      the faces of a cell, as they came
//! level-0/plan.json          up to which cost the cells of the level are collapsed, or that they fit
//! level-0/cell-3.reduced     what was left of it
//! level-1/cell-0.region      neighbours joined
//! level-1/cell-0.finished    the same as part of a result
//! ...
//! level-3/cell-2.stage       the third result, made of all that is left of level 3
//! ```
//!
//! Beside each region lies its record, as JSON, with a checksum; it is written last. A step whose record is
//! there and fits the file is done.

use std::fs;
use std::path::{Path, PathBuf};

use mesh_core::TriMesh;
use mesh_io::ReadOptions;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use simplify::blocks::{CostThreshold, Forecast, Rules};
use simplify::{Options, Target, rules};

use crate::cells::Cells;
use crate::claim::{MARK, SCRATCH, claim};
use crate::error::Error;
use crate::incoming::{Incoming, Input, Summary};
use crate::join::join;
use crate::plan::{Next, Plan, Situation, has_strips};
use crate::reduce::{proved_distance, reduce};
use crate::region::Region;
use crate::sizes::Sizes;
use crate::split::{Repairs, forecast, split};
use crate::strips::Strips;

/// What a run is to do.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    /// How the mesh is simplified. `target` has to name a number of faces or a ratio.
    pub options: Options,
    /// Finer levels of detail, which are results too: each names a number of faces or a ratio. All results are
    /// sorted, so that these may be the coarser ones as well.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub finer: Vec<Target>,
    /// What becomes of faces and vertices that no mesh can have.
    pub repairs: Repairs,
    /// How much is held at a time.
    pub sizes: Sizes,
    /// Whether the distance from the input is proved, step by step, up to this share of the diagonal of the
    /// bounding box for each.
    pub prove: Option<f64>,
}

/// What `run.json` says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// The version of the folder.
    pub version: u32,
    /// What is done.
    pub settings: Settings,
    /// What the input was.
    pub source: Source,
    /// What is in it.
    pub summary: Summary,
    /// Which part of space is whose.
    pub cells: Cells,
}

/// By what an input is known again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// Its name, without the folder.
    pub name: String,
    /// Its length in bytes; nothing for a stream.
    pub bytes: Option<u64>,
    /// When it was changed last, in nanoseconds since 1970; nothing for a stream.
    pub changed: Option<u128>,
}

impl Source {
    /// What is known of a file.
    ///
    /// # Errors
    /// It is not there.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let metadata = fs::metadata(path).map_err(Error::io(path))?;
        let since = |time: std::time::SystemTime| time.duration_since(std::time::UNIX_EPOCH).ok();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let changed = metadata.modified().ok().and_then(since).map(|time| time.as_nanos());
        Ok(Self { name, bytes: metadata.is_file().then_some(metadata.len()), changed })
    }
}

/// What is known of a region on disk.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The SHA-256 checksum of the file.
    pub sha256: String,
    /// The bytes of the file.
    pub bytes: u64,
    /// The faces that belong to the cell.
    pub faces: u64,
    /// What a pass over the region would take away at which costs; of regions that are to be collapsed.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub forecast: Option<Forecast>,
    /// How far the faces of the cell were moved by the pass, proved; of regions that were collapsed.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub moved: Option<f64>,
}

/// The folder of a run.
#[derive(Clone, Debug)]
pub struct Work {
    folder: PathBuf,
    manifest: Manifest,
}

const VERSION: u32 = 1;
/// Which of the files of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Region,
    Reduced,
    Finished,
    /// Of the rest that is done in one piece, with the number of a result in place of a cell.
    Stage,
}

impl Work {
    /// Splits an input into regions, in a folder that is made if it is not there. What is there of the same
    /// run stays.
    ///
    /// # Errors
    /// The input cannot be read or used, the folder is that of another run, or it cannot be written.
    pub fn split(
        folder: &Path,
        input: Input<'_>,
        reading: &ReadOptions,
        settings: Settings,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let source = match &input {
            Input::Path(path) => Source::of(path)?,
            Input::Stream(_, name) => {
                Source { name: name.display().to_string(), bytes: None, changed: None }
            }
        };
        if rules(&settings.options, 1.0).is_none() {
            return Err(Error::Unsupported(
                "what the options ask for",
                "take a preset with quadrics, without constraints and limits other than a number of faces",
            ));
        }
        let is_count = |limits: &Target| {
            let Target { faces, ratio, time: None, vertices: None, cost: None, collapses: None } =
                limits
            else {
                return false;
            };
            faces.is_some() || ratio.is_some()
        };
        if !settings.finer.iter().all(is_count) {
            return Err(Error::Unsupported(
                "a level of detail",
                "name a number of faces or a ratio for each, and nothing else",
            ));
        }
        fs::create_dir_all(folder).map_err(Error::io(folder))?;
        if folder.join(RUN).exists() {
            let work = Self::open(folder)?;
            work.is_of(&source, &settings)?;
            return Ok(work);
        }
        claim(folder)?;
        let work = Self::split_new(folder, input, reading, settings, source, see);
        let _ = fs::remove_dir_all(folder.join(SCRATCH));
        if work.is_err() {
            // Nobody can go on with a part of it.
            remove_levels(folder);
            let _ = fs::remove_file(folder.join(MARK));
            let _ = fs::remove_dir(folder);
        }
        work
    }

    fn split_new(
        folder: &Path,
        input: Input<'_>,
        reading: &ReadOptions,
        settings: Settings,
        source: Source,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let scratch = folder.join(SCRATCH);
        let _ = fs::remove_dir_all(&scratch);
        // What is left of a run that was killed while it was split or removed.
        remove_levels(folder);
        fs::create_dir_all(&scratch).map_err(Error::io(&scratch))?;
        let sizes = settings.sizes;
        let size = source.bytes.unwrap_or(0);
        let reads = &mut |items| see(Step { what: "reading", done: items, of: size, level: 0 });
        let mut incoming = Incoming::read(input, reading, &scratch, sizes.stream, reads)?;
        let depth = sizes.depth(incoming.summary.triangles);
        let cells = Cells::new(core::mem::take(&mut incoming.sample), depth);
        let summary = incoming.summary.clone();
        let manifest = Manifest { version: VERSION, settings, source, summary, cells };
        let work = Self { folder: folder.to_owned(), manifest };
        let level = work.level_folder(0);
        fs::create_dir_all(&level).map_err(Error::io(&level))?;
        let (cells, repairs) = (&work.manifest.cells, work.manifest.settings.repairs);
        let mut done = 0;
        split(&incoming, cells, repairs, &scratch, sizes.stream / 2, &mut |region| {
            work.put(&region, State::Region, None)?;
            done += 1;
            let step = Step { what: "splitting", done, of: u64::from(cells.count()), level: 0 };
            if see(step) { Ok(()) } else { Err(Error::Stopped) }
        })?;
        drop(incoming);
        // What is left in the scratch folder by one that is killed is in nobody's way.
        let (prepared, run) = (scratch.join(RUN), folder.join(RUN));
        put_json(&prepared, &work.manifest)?;
        fs::rename(&prepared, &run).map_err(Error::io(&run))?;
        Ok(work)
    }

    /// The folder of a run whose input was split.
    ///
    /// # Errors
    /// It is none.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(RUN);
        let manifest: Manifest = get_json(&path)?;
        if manifest.version != VERSION {
            return Err(Error::damaged(
                &path,
                format!("version {} of the folder", manifest.version),
            ));
        }
        Ok(Self { folder: folder.to_owned(), manifest })
    }

    /// Whether the folder is one of this input and these settings.
    fn is_of(&self, source: &Source, settings: &Settings) -> Result<(), Error> {
        let other = |what| Err(Error::OtherRun { path: self.folder.clone(), what });
        if *source != self.manifest.source {
            return other("input");
        }
        let as_json = |settings: &Settings| serde_json::to_value(settings).ok();
        if as_json(settings) != as_json(&self.manifest.settings) {
            return other("set of options");
        }
        Ok(())
    }

    /// Removes what runs leave in the folder, and the folder if nothing else is in it.
    pub fn remove(self) {
        // What cannot be removed is in nobody's way but that of the disk. Without the first of these files nobody
        // goes on with what is left, without the second one the folder must be empty.
        let _ = fs::remove_file(self.folder.join(RUN));
        remove_levels(&self.folder);
        let _ = fs::remove_file(self.folder.join(MARK));
        let _ = fs::remove_dir(&self.folder);
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What the run is.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The numbers of faces of the results, from the finest to the coarsest, with which the run ends.
    #[must_use]
    pub fn targets(&self) -> Vec<u64> {
        let faces = usize::try_from(self.manifest.summary.triangles).unwrap_or(usize::MAX);
        let Settings { options, finer, .. } = &self.manifest.settings;
        let limits = finer.iter().chain([&options.target]);
        let mut targets: Vec<u64> = limits.map(|limits| limits.face_target(faces) as u64).collect();
        targets.sort_unstable_by(|a, b| b.cmp(a));
        targets
    }

    /// The number of faces of the coarsest of them.
    #[must_use]
    pub fn target(&self) -> u64 {
        self.targets().last().copied().unwrap_or(0)
    }

    /// Whether all results fit into memory, so that each of them is one mesh.
    #[must_use]
    pub fn fits(&self) -> bool {
        let Manifest { settings, summary, cells, .. } = &self.manifest;
        let rest = settings.sizes.rest_faces;
        let is_whole = cells.count() == 1 || summary.triangles <= rest;
        is_whole || self.targets().first().is_none_or(|&finest| finest <= rest)
    }

    /// How closely distances are proved, in model units, if they are.
    pub(crate) fn tolerance(&self) -> Option<f64> {
        self.manifest.settings.prove.map(|share| share * self.manifest.summary.size())
    }

    /// What regions go by.
    ///
    /// # Errors
    /// The options ask for what regions do not know.
    pub fn rules(&self) -> Result<Rules, Error> {
        rules(&self.manifest.settings.options, self.manifest.summary.size())
            .ok_or(Error::Unsupported("what the options ask for", "take other options"))
    }

    fn level_folder(&self, level: u32) -> PathBuf {
        self.folder.join(format!("level-{level}"))
    }

    fn path(&self, level: u32, cell: u32, state: State) -> PathBuf {
        let extension = match state {
            State::Region => "region",
            State::Reduced => "reduced",
            State::Finished => "finished",
            State::Stage => "stage",
        };
        self.level_folder(level).join(format!("cell-{cell}.{extension}"))
    }

    /// Writes a region and its record.
    fn put(&self, region: &Region, state: State, moved: Option<f64>) -> Result<Record, Error> {
        let path = self.path(region.level, region.cell, state);
        let sha256 = region.write(&path)?;
        let bytes = fs::metadata(&path).map_err(Error::io(&path))?.len();
        let faces = region.own_face_count() as u64;
        let forecast = match state {
            State::Region => Some(forecast(region.clone(), &self.rules()?)),
            State::Reduced | State::Finished | State::Stage => None,
        };
        let record = Record { sha256, bytes, faces, forecast, moved };
        put_json(&record_path(&path), &record)?;
        Ok(record)
    }

    /// The record of a step, if it is done: the file is there, and as long as it should be.
    fn record(&self, level: u32, cell: u32, state: State) -> Option<Record> {
        let path = self.path(level, cell, state);
        let record: Record = get_json(&record_path(&path)).ok()?;
        let bytes = fs::metadata(&path).ok()?.len();
        (bytes == record.bytes).then_some(record)
    }

    fn get(&self, level: u32, cell: u32, state: State) -> Result<Region, Error> {
        let path = self.path(level, cell, state);
        let record: Record = get_json(&record_path(&path))?;
        let (region, sha256) = Region::read_checked(&path)?;
        if sha256 != record.sha256 || (region.level, region.cell) != (level, cell) {
            return Err(Error::damaged(&path, "not the file that its record is about"));
        }
        Ok(region)
    }

    /// The number of cells of a level, whose regions need not be there yet.
    ///
    /// # Errors
    /// A level below has no plan yet.
    pub fn cells(&self, level: u32) -> Result<u32, Error> {
        if level == 0 {
            return Ok(self.manifest.cells.count());
        }
        let below: Plan = self.read_plan(level - 1)?;
        match below.next {
            Next::Pass { bits, .. } => Ok(below.cells.div_ceil(1 << bits)),
            Next::Strips { .. } => Ok(below.cells),
            _ => Err(Error::damaged(&self.plan_path(level), "there is no such level")),
        }
    }

    fn plan_path(&self, level: u32) -> PathBuf {
        self.level_folder(level).join("plan.json")
    }

    fn read_plan(&self, level: u32) -> Result<Plan, Error> {
        get_json(&self.plan_path(level))
    }

    /// What is done with a level, whose regions have to be there: from what they say, and nothing else. The
    /// plan is written down, and found there again.
    ///
    /// # Errors
    /// A region is missing, or the plan cannot be written.
    pub fn plan(&self, level: u32) -> Result<Plan, Error> {
        if let Ok(plan) = self.read_plan(level) {
            return Ok(plan);
        }
        let cells = self.cells(level)?;
        let mut forecasts = Vec::new();
        let mut faces = 0;
        for cell in 0..cells {
            let path = self.path(level, cell, State::Region);
            let missing = || Error::damaged(&path, "the region is not there");
            let record = self.record(level, cell, State::Region).ok_or_else(missing)?;
            faces += record.faces;
            forecasts.push(record.forecast.unwrap_or_default());
        }
        let below: Vec<Plan> = (0..level).map(|l| self.read_plan(l)).collect::<Result<_, _>>()?;
        let met: usize = below.iter().map(|plan| plan.results as usize).sum();
        let situation = Situation {
            level,
            cells,
            faces,
            forecasts: &forecasts,
            before: below.last().copied(),
            has_strips: has_strips(below.iter().rev()),
            targets: &self.targets()[met..],
            sizes: self.manifest.settings.sizes,
        };
        let plan = situation.plan();
        put_json(&self.plan_path(level), &plan)?;
        Ok(plan)
    }

    /// Collapses the region of a cell as its level is planned.
    ///
    /// # Errors
    /// The region or the plan is missing or damaged, or the result cannot be written.
    pub fn reduce(&self, level: u32, cell: u32) -> Result<Record, Error> {
        if let Some(done) = self.record(level, cell, State::Reduced) {
            return Ok(done);
        }
        let Next::Pass { ceiling, .. } = self.read_plan(level)?.next else {
            return Err(Error::damaged(
                &self.plan_path(level),
                "no cells are collapsed on this level",
            ));
        };
        if level > 0 {
            // What was damaged since is made again.
            self.join(level, cell)?;
        }
        let region = self.get(level, cell, State::Region)?;
        let before = self.tolerance().map(|tolerance| (region.clone(), tolerance));
        let reduced = reduce(region, &self.rules()?, ceiling);
        let moved = match before {
            Some((before, tolerance)) => Some(proved_distance(&before, &reduced, tolerance)?),
            None => None,
        };
        self.put(&reduced, State::Reduced, moved)
    }

    /// Joins the regions of the level below that make up a cell.
    ///
    /// # Errors
    /// One of them is missing or damaged, or the result cannot be written.
    pub fn join(&self, level: u32, cell: u32) -> Result<Record, Error> {
        if let Some(done) = self.record(level, cell, State::Region) {
            return Ok(done);
        }
        let below = level.checked_sub(1).map(|below| self.read_plan(below)).transpose()?;
        if let Some(Plan { cells, next: Next::Strips { ceiling }, .. }) = below {
            self.collapse_rims(level - 1, cells, ceiling)?;
            let path = self.path(level, cell, State::Region);
            let no_cell = || Error::damaged(&path, "there is no such cell");
            return self.record(level, cell, State::Region).ok_or_else(no_cell);
        }
        let Some(Plan { cells, next: Next::Pass { bits, .. }, .. }) = below else {
            return Err(Error::damaged(&self.plan_path(level), "nothing is joined on this level"));
        };
        let parts = (cell << bits)..((cell + 1) << bits).min(cells);
        let regions: Result<Vec<Region>, Error> =
            parts.map(|part| self.reduced(level - 1, part)).collect();
        let joined = join(regions?, bits)?;
        let folder = self.level_folder(level);
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        self.put(&joined, State::Region, None)
    }

    /// Collapses the rims of the cells of a level, and writes those of the next one.
    fn collapse_rims(&self, level: u32, cells: u32, ceiling: CostThreshold) -> Result<(), Error> {
        let read = |cell| {
            if level > 0 {
                self.join(level, cell)?;
            }
            self.get(level, cell, State::Region)
        };
        // Besides the strips there is the cell that they are taken from.
        let most = self.manifest.settings.sizes.region_faces / 4 * 3;
        let (strips, region) = Strips::gather(level, cells, most, &self.folder, read)?.unzip();
        let region = region.unwrap_or(Region { level, ..Region::default() });
        let before = self.tolerance().map(|tolerance| (region.clone(), tolerance));
        let reduced = reduce(region, &self.rules()?, ceiling);
        let moved = match before {
            Some((before, tolerance)) => Some(proved_distance(&before, &reduced, tolerance)?),
            None => None,
        };
        self.put(&reduced, State::Reduced, moved)?;
        let folder = self.level_folder(level + 1);
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        for cell in 0..cells {
            let old = read(cell)?;
            let next = match &strips {
                Some(strips) => strips.put_back(&reduced, &old, &self.folder)?,
                None => Region { level: level + 1, ..old },
            };
            self.put(&next, State::Region, None)?;
        }
        Ok(())
    }

    /// Everything that is left on a level, as one region.
    ///
    /// # Errors
    /// A region is missing or damaged, or all of them are too many for 32 bits.
    pub fn whole(&self, level: u32) -> Result<Region, Error> {
        let cells = self.cells(level)?;
        let regions: Result<Vec<Region>, Error> =
            (0..cells).map(|cell| self.get(level, cell, State::Region)).collect();
        join(regions?, cells.next_power_of_two().trailing_zeros())
    }

    /// The region of a cell of a level.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn region(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.get(level, cell, State::Region)
    }

    /// The region of a cell of the level that is the result.
    pub(crate) fn region_to_finish(&self, level: u32, cell: u32) -> Result<Region, Error> {
        if self.plan(level)?.results == 0 {
            let path = self.plan_path(level);
            return Err(Error::damaged(&path, "this level is not finished region by region"));
        }
        if level > 0 {
            self.join(level, cell)?;
        }
        self.get(level, cell, State::Region)
    }

    /// The record of a region that was finished.
    pub(crate) fn finished(&self, level: u32, cell: u32) -> Option<Record> {
        self.record(level, cell, State::Finished)
    }

    pub(crate) fn put_finished(
        &self,
        region: &Region,
        moved: Option<f64>,
    ) -> Result<Record, Error> {
        self.put(region, State::Finished, moved)
    }

    /// The region of a cell of the result, finished.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn finished_region(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.get(level, cell, State::Finished)
    }

    /// The record of a result that was made of the rest in one piece.
    pub(crate) fn stage(&self, level: u32, number: u32) -> Option<Record> {
        self.record(level, number, State::Stage)
    }

    pub(crate) fn put_stage(&self, stage: &Region, moved: Option<f64>) -> Result<Record, Error> {
        self.put(stage, State::Stage, moved)
    }

    /// A result that was made of the rest in one piece.
    pub(crate) fn stage_mesh(&self, level: u32, number: u32) -> Result<TriMesh, Error> {
        let Region { positions, triangles, .. } = self.get(level, number, State::Stage)?;
        let path = self.path(level, number, State::Stage);
        TriMesh::from_triangles(&positions, &triangles)
            .map_err(|error| Error::damaged(&path, error.to_string()))
    }

    /// How far the passes so far have moved the surface at most, if that was proved: the largest distance
    /// over the cells of each, added up.
    ///
    /// # Errors
    /// A record is missing.
    pub fn moved(&self, levels: u32) -> Result<Option<f64>, Error> {
        if self.manifest.settings.prove.is_none() {
            return Ok(None);
        }
        let mut sum = 0.0;
        for level in 0..levels {
            let mut largest = 0.0_f64;
            let plan = self.read_plan(level)?;
            // All strips are one region.
            let is_strips = matches!(plan.next, Next::Strips { .. });
            for cell in 0..if is_strips { 1 } else { plan.cells } {
                let path = record_path(&self.path(level, cell, State::Reduced));
                let record: Record = get_json(&path)?;
                largest = largest.max(record.moved.unwrap_or(f64::INFINITY));
            }
            sum = add_up(sum, largest);
        }
        Ok(Some(sum))
    }

    /// Removes the regions of a level that are not needed any more; their records stay.
    pub(crate) fn tidy(&self, level: u32) {
        for cell in 0..self.cells(level).unwrap_or(0) {
            let _ = fs::remove_file(self.path(level, cell, State::Reduced));
            if level > 0 {
                let _ = fs::remove_file(self.path(level, cell, State::Region));
            }
        }
    }

    /// What a region was collapsed to, which is done if it was not yet.
    fn reduced(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.reduce(level, cell)?;
        self.get(level, cell, State::Reduced)
    }

    /// Whether the region of a cell is there.
    pub(crate) fn has_region(&self, level: u32, cell: u32) -> bool {
        self.record(level, cell, State::Region).is_some()
    }

    /// The plan of the highest level whose regions are all there. Of those below, some may have been removed
    /// since.
    ///
    /// # Errors
    /// No level is there, or the plan cannot be written.
    pub fn current(&self) -> Result<Plan, Error> {
        let (mut highest, mut level) = (0, 0);
        while let Ok(cells) = self.cells(level) {
            if (0..cells).all(|cell| self.has_region(level, cell)) {
                highest = level;
            }
            level += 1;
        }
        self.plan(highest)
    }
}

/// The sum, rounded up.
pub(crate) fn add_up(a: f64, b: f64) -> f64 {
    let sum = a + b;
    if sum > 0.0 { sum.next_up() } else { sum }
}

/// How far a run has come; given to the observer, which says whether to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// What is being done.
    pub what: &'static str,
    /// How much of that is done.
    pub done: u64,
    /// Of how much in all, where that is known.
    pub of: u64,
    /// On which level.
    pub level: u32,
}

const RUN: &str = "run.json";

fn record_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// Removes the levels in the folder of a run, as far as that is possible.
fn remove_levels(folder: &Path) {
    let is_level = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with("level-");
    for entry in fs::read_dir(folder).into_iter().flatten().flatten().filter(is_level) {
        let _ = fs::remove_dir_all(entry.path());
    }
}

pub(crate) fn put_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::damaged(path, error.to_string()))?;
    Ok(mesh_io::replace_file(path, |writer| writer.write_all(text.as_bytes()))?)
}

fn get_json<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    let text = fs::read(path).map_err(Error::io(path))?;
    serde_json::from_slice(&text).map_err(|error| Error::damaged(path, error.to_string()))
}
