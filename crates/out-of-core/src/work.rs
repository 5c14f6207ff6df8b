//! The folder of a run, and the steps of the run: each from files to files.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mesh_core::TriMesh;
use mesh_io::ReadOptions;
use serde::de::DeserializeOwned;
use simplify::blocks::{CostThreshold, Rules};
use simplify::rules;

use crate::cells::Cells;
use crate::error::Error;
use crate::ingest::{Ingested, Input};
use crate::join::join;
use crate::layout::{self, Kind, RUN, SCRATCH};
use crate::lock::{Alone, FolderLock, MARK};
use crate::manifest::{InputIdentity, Manifest, Settings};
use crate::plan::{Next, Plan, Situation, has_seam_strips};
use crate::private_files;
use crate::record::Record;
use crate::reduce::{proved_distance, reduce};
use crate::region::Region;
use crate::sealed_json::{self, Origin, Sealed, combine};
use crate::seam_strips::SeamStrips;
use crate::split::{Repaired, forecast, split};
use crate::step::Step;

/// The largest size of a manifest in bytes. Planes between cells take most of it.
const LONGEST_MANIFEST: u64 = 256 << 20;
/// The largest size of a plan or a record in bytes.
const LONGEST_RECORD: u64 = 16 << 20;

/// The folder of a run.
///
/// A value of this type holds a lock on the folder, shared with other processes that do steps of the run.
/// [`Work::split`] and [`run`](crate::run()) need the folder for themselves.
#[derive(Clone, Debug)]
pub struct Work {
    folder: PathBuf,
    manifest: Manifest,
    /// The checksum of the manifest, by which the other files name their run.
    run: String,
    lock: Arc<FolderLock>,
    repaired: Repaired,
}

impl Work {
    /// Splits an input into regions, in a folder that is created if it is missing. If the folder holds the same run
    /// already, nothing is done.
    ///
    /// # Errors
    /// The input cannot be read or used, the folder belongs to another run or another user, another process works in
    /// it, or it cannot be written.
    pub fn split(
        folder: &Path,
        input: Input<'_>,
        reading: &ReadOptions,
        settings: Settings,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let identity = match &input {
            Input::Path(path) => InputIdentity::of(path)?,
            Input::Stream(_, name) => {
                InputIdentity { name: name.display().to_string(), bytes: None, changed: None }
            }
        };
        settings.check()?;
        if fs::symlink_metadata(folder.join(RUN)).is_ok() {
            let work = Self::open(folder)?;
            work.check_is_of(&identity, &settings)?;
            return Ok(work);
        }
        let lock = Arc::new(FolderLock::claim(folder)?);
        // A run that was killed while it was split or removed has left no manifest.
        layout::remove_content(folder);
        let work = Self::split_new(lock, input, reading, settings, identity, observer);
        let _ = fs::remove_dir_all(folder.join(SCRATCH));
        if let Ok(work) = &work {
            work.lock.admit_others()?;
        } else {
            // A part of the regions is of no use.
            layout::remove_content(folder);
            let _ = fs::remove_file(folder.join(MARK));
            let _ = fs::remove_dir(folder);
        }
        work
    }

    /// Splits an input into the regions of level 0 of an empty folder.
    fn split_new(
        lock: Arc<FolderLock>,
        input: Input<'_>,
        reading: &ReadOptions,
        settings: Settings,
        identity: InputIdentity,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Self, Error> {
        let folder = lock.folder().to_owned();
        let scratch = folder.join(SCRATCH);
        private_files::create_folder(&scratch).map_err(Error::io(&scratch))?;
        let capacity = settings.capacity;
        let of = identity.bytes.unwrap_or(0);
        let reads = &mut |done| observer(Step { what: "reading", done, of, level: 0 });
        let joins_loose = settings.repairs.join_loose_faces;
        let mut ingested =
            Ingested::read(input, reading, joins_loose, &scratch, capacity.stream, reads)?;
        if let (Some((vertex, position)), false) =
            (ingested.not_finite, settings.repairs.drop_not_finite)
        {
            return Err(Error::NotFinite { vertex, position });
        }
        let depth = capacity.checked_depth(ingested.summary.triangles)?;
        let cells = Cells::new(core::mem::take(&mut ingested.sample), depth);
        let summary = ingested.summary.clone();
        let manifest = Manifest { settings, input: identity, summary, cells };
        // Records name the manifest by its checksum. The manifest is put in its place when all records exist.
        let prepared = scratch.join(RUN);
        let nonce = format!("{:032x}", fastrand::u128(..));
        let origin = Origin { run: &nonce, file: RUN, inputs: "" };
        let run = sealed_json::write(&prepared, origin, &manifest)?;
        let mut work = Self { folder, manifest, run, lock, repaired: Repaired::default() };
        let (cells, repairs) = (&work.manifest.cells, work.manifest.settings.repairs);
        let (mut done, of) = (0, u64::from(cells.count()));
        let repaired =
            split(&ingested, cells, repairs, &scratch, capacity.stream / 2, &mut |region| {
                work.put(&region, Kind::Region, None)?;
                done += 1;
                let step = Step { what: "splitting", done, of, level: 0 };
                if observer(step) { Ok(()) } else { Err(Error::Stopped) }
            })?;
        drop(ingested);
        work.repaired = repaired;
        let path = work.folder.join(RUN);
        fs::rename(&prepared, &path).map_err(Error::io(&path))?;
        Ok(work)
    }

    /// Opens the folder of a run whose input was split.
    ///
    /// # Errors
    /// There is no such folder, it belongs to another user, another process has it alone, or its manifest is damaged.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let lock = FolderLock::share(folder)?;
        layout::check_levels(folder)?;
        let path = folder.join(RUN);
        let read = sealed_json::read::<Manifest>(&path, RUN, LONGEST_MANIFEST)?;
        let sealed = read.ok_or_else(|| Error::NoWorkFolder { path: folder.to_owned() })?;
        sealed.content.check(&path)?;
        let Sealed { content: manifest, seal: run, .. } = sealed;
        let (folder, repaired) = (folder.to_owned(), Repaired::default());
        Ok(Self { folder, manifest, run, lock: Arc::new(lock), repaired })
    }

    /// Checks that the folder belongs to this input and these settings.
    fn check_is_of(&self, input: &InputIdentity, settings: &Settings) -> Result<(), Error> {
        let other = |what| Err(Error::OtherRun { path: self.folder.clone(), what });
        if *input != self.manifest.input {
            return other("input");
        }
        let as_json = |settings: &Settings| serde_json::to_value(settings).ok();
        if as_json(settings) != as_json(&self.manifest.settings) {
            return other("set of options");
        }
        Ok(())
    }

    /// Removes the files of the run, and the folder if nothing else is in it.
    pub fn remove(self) {
        // Other processes that still work in it would lose their files.
        let Ok(_alone) = self.lock.alone() else { return };
        // Files that cannot be removed only take space. Without the manifest, no run continues with them.
        let _ = fs::remove_file(self.folder.join(RUN));
        layout::remove_content(&self.folder);
        let _ = fs::remove_file(self.folder.join(MARK));
        let _ = fs::remove_dir(&self.folder);
    }

    /// Keeps other processes out of the folder until the guard is dropped.
    pub(crate) fn alone(&self) -> Result<Alone<'_>, Error> {
        let alone = self.lock.alone()?;
        layout::remove_leftovers(&self.folder);
        Ok(alone)
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The repairs of the input, if it was split by this process; otherwise nothing.
    #[must_use]
    pub fn repaired(&self) -> Repaired {
        self.repaired
    }

    /// The settings, the input and the cells.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The numbers of faces of all results, from the finest to the coarsest.
    #[must_use]
    pub fn targets(&self) -> Vec<u64> {
        self.manifest.settings.targets(self.manifest.summary.triangles)
    }

    /// The number of faces of the coarsest result.
    #[must_use]
    pub fn target(&self) -> u64 {
        self.targets().last().copied().unwrap_or(0)
    }

    /// Whether each result fits into memory as one mesh.
    #[must_use]
    pub fn fits(&self) -> bool {
        let Manifest { settings, summary, cells, .. } = &self.manifest;
        let most = settings.capacity.in_memory_faces;
        let input_fits = cells.count() == 1 || summary.triangles <= most;
        input_fits || self.targets().first().is_none_or(|&finest| finest <= most)
    }

    /// The tolerance of proofs in model units, if distances are proved.
    pub(crate) fn tolerance(&self) -> Option<f64> {
        self.manifest.settings.prove.map(|share| share * self.manifest.summary.size())
    }

    /// The rules of the collapses of regions.
    ///
    /// # Errors
    /// The options need the whole mesh.
    pub fn rules(&self) -> Result<Rules, Error> {
        rules(&self.manifest.settings.options, self.manifest.summary.size())
            .ok_or(Error::Unsupported("this set of options", "take other options"))
    }

    fn path(&self, level: u32, cell: u32, kind: Kind) -> PathBuf {
        self.folder.join(layout::cell(level, cell, kind))
    }

    /// Writes a record or a plan, and returns its checksum.
    fn write_sealed<T: serde::Serialize>(
        &self,
        file: &str,
        inputs: &str,
        content: &T,
    ) -> Result<String, Error> {
        let origin = Origin { run: &self.run, file, inputs };
        sealed_json::write(&self.folder.join(file), origin, content)
    }

    /// Reads a record or a plan of this run. `None` if it does not exist.
    fn read_sealed<T: DeserializeOwned>(&self, file: &str) -> Result<Option<Sealed<T>>, Error> {
        let path = self.folder.join(file);
        let sealed = sealed_json::read(&path, file, LONGEST_RECORD)?;
        if sealed.as_ref().is_some_and(|sealed: &Sealed<T>| sealed.run != self.run) {
            return Err(Error::damaged(&path, "it belongs to another run"));
        }
        Ok(sealed)
    }

    /// The checksum of the plan of a level; empty if there is none.
    fn seal_of_plan(&self, level: u32) -> Result<String, Error> {
        let plan = self.read_sealed::<Plan>(&layout::plan(level))?;
        Ok(plan.map(|plan| plan.seal).unwrap_or_default())
    }

    /// The checksum of a record; empty if there is none.
    fn seal_of(&self, level: u32, cell: u32, kind: Kind) -> Result<String, Error> {
        let record = self.read_sealed::<Record>(&layout::record(level, cell, kind))?;
        Ok(record.map(|record| record.seal).unwrap_or_default())
    }

    /// The checksum over the inputs of a region.
    fn inputs_of(&self, level: u32, cell: u32, kind: Kind) -> Result<String, Error> {
        let plan = match kind {
            Kind::Region => level.checked_sub(1),
            Kind::Reduced | Kind::Refined | Kind::LodOutput => Some(level),
        };
        let Some(planned) = plan else { return Ok(combine([&self.run])) };
        let mut seals = vec![self.seal_of_plan(planned)?];
        match (kind, self.read_plan(planned)?.map(|plan| plan.next)) {
            (Kind::Region, Some(Next::Pass { bits, .. })) => {
                for part in self.parts(level, cell, bits)? {
                    seals.push(self.seal_of(planned, part, Kind::Reduced)?);
                }
            }
            (Kind::Region, _) => {
                seals.push(self.seal_of(planned, 0, Kind::Reduced)?);
                seals.push(self.seal_of(planned, cell, Kind::Region)?);
            }
            (Kind::Reduced, Some(Next::Pass { .. })) | (Kind::Refined, _) => {
                seals.push(self.seal_of(level, cell, Kind::Region)?);
            }
            // The plan of the level covers all of its regions.
            (Kind::Reduced | Kind::LodOutput, _) => {}
        }
        Ok(combine(seals))
    }

    /// Writes a region and its record.
    fn put(&self, region: &Region, kind: Kind, moved: Option<f64>) -> Result<Record, Error> {
        let Region { level, cell, .. } = *region;
        layout::create_level(&self.folder, level)?;
        let path = self.path(level, cell, kind);
        let (sha256, bytes) = region.write(&path)?;
        let faces = region.own_face_count() as u64;
        let forecast = match kind {
            Kind::Region => Some(forecast(region.clone(), &self.rules()?)),
            Kind::Reduced | Kind::Refined | Kind::LodOutput => None,
        };
        let moved = moved.filter(|moved| moved.is_finite());
        let record = Record { sha256, bytes, faces, forecast, moved };
        let inputs = self.inputs_of(level, cell, kind)?;
        self.write_sealed(&layout::record(level, cell, kind), &inputs, &record)?;
        Ok(record)
    }

    /// The record of a step, even if its region was removed. `None` if the step is not done.
    fn read_record(&self, level: u32, cell: u32, kind: Kind) -> Result<Option<Record>, Error> {
        let file = layout::record(level, cell, kind);
        let Some(sealed) = self.read_sealed::<Record>(&file)? else { return Ok(None) };
        let path = self.folder.join(file);
        let proves = self.manifest.settings.prove.is_some();
        sealed.content.check(kind, proves).map_err(|reason| Error::damaged(&path, reason))?;
        if sealed.inputs != self.inputs_of(level, cell, kind)? {
            return Err(Error::damaged(&path, "it was made from files that have changed since"));
        }
        Ok(Some(sealed.content))
    }

    /// The record of a finished step: its region exists, and has the right length.
    fn record(&self, level: u32, cell: u32, kind: Kind) -> Result<Option<Record>, Error> {
        let path = self.path(level, cell, kind);
        let bytes = match fs::symlink_metadata(&path) {
            Ok(metadata) if metadata.is_file() => metadata.len(),
            Ok(_) => return Err(Error::damaged(&path, "this is not a regular file")),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Error::io(&path)(error)),
        };
        Ok(self.read_record(level, cell, kind)?.filter(|record| record.bytes == bytes))
    }

    fn get(&self, level: u32, cell: u32, kind: Kind) -> Result<Region, Error> {
        let path = self.path(level, cell, kind);
        let missing = || Error::damaged(&path, "the region or its record is not there");
        let record = self.read_record(level, cell, kind)?.ok_or_else(missing)?;
        let (region, sha256) = Region::read_checked(&path)?;
        let fits = sha256 == record.sha256 && (region.level, region.cell) == (level, cell);
        if !fits || region.own_face_count() as u64 != record.faces {
            return Err(Error::damaged(&path, "this is not the file that its record describes"));
        }
        Ok(region)
    }

    /// The number of cells of a level. Their regions need not exist yet.
    ///
    /// # Errors
    /// A level below has no plan yet.
    pub fn cells(&self, level: u32) -> Result<u32, Error> {
        let no_level =
            || Error::damaged(&self.folder.join(layout::plan(level)), "there is no such level");
        self.cells_if_planned(level)?.ok_or_else(no_level)
    }

    /// The number of cells of a level; `None` if the level below is the last one, or has no plan yet.
    fn cells_if_planned(&self, level: u32) -> Result<Option<u32>, Error> {
        let Some(below) = level.checked_sub(1) else {
            return Ok(Some(self.manifest.cells.count()));
        };
        Ok(self.read_plan(below)?.and_then(|below| below.cells_above()))
    }

    /// The cells of the level below that make up a cell of this one.
    fn parts(&self, level: u32, cell: u32, bits: u32) -> Result<core::ops::Range<u32>, Error> {
        if cell >= self.cells(level)? {
            let path = self.path(level, cell, Kind::Region);
            return Err(Error::damaged(&path, "there is no such cell"));
        }
        let below = self.cells(level.saturating_sub(1))?;
        Ok((cell << bits)..((cell + 1) << bits).min(below))
    }

    /// The plan of a level as written, after a check of its numbers. `None` if it does not exist.
    fn read_plan(&self, level: u32) -> Result<Option<Plan>, Error> {
        let file = layout::plan(level);
        let Some(sealed) = self.read_sealed::<Plan>(&file)? else { return Ok(None) };
        let faces = self.manifest.summary.triangles;
        let checked = sealed.content.check(level, self.manifest.cells.count(), faces);
        checked.map_err(|reason| Error::damaged(&self.folder.join(file), reason))?;
        Ok(Some(sealed.content))
    }

    fn planned(&self, level: u32) -> Result<Plan, Error> {
        let missing = || {
            let path = self.folder.join(layout::plan(level));
            Error::damaged(&path, "the level has no plan yet")
        };
        self.read_plan(level)?.ok_or_else(missing)
    }

    /// Plans a level whose regions all exist, from the records of these regions only, and writes the plan. If a plan
    /// exists already, it must be the same.
    ///
    /// # Errors
    /// A region is missing, a record is damaged, or the plan cannot be written.
    pub fn plan(&self, level: u32) -> Result<Plan, Error> {
        let cells = self.cells(level)?;
        let file = layout::plan(level);
        let path = self.folder.join(&file);
        let written = self.read_sealed::<Plan>(&file)?;
        let mut seals = vec![match level.checked_sub(1) {
            Some(below) => self.seal_of_plan(below)?,
            None => self.run.clone(),
        }];
        let mut forecasts = Vec::new();
        let mut faces = 0;
        for cell in 0..cells {
            // Regions of levels that were planned may have been removed since.
            let record = match &written {
                Some(_) => self.read_record(level, cell, Kind::Region)?,
                None => self.record(level, cell, Kind::Region)?,
            };
            let region = || self.path(level, cell, Kind::Region);
            let record = record.ok_or_else(|| Error::damaged(&region(), "it is not there"))?;
            seals.push(self.seal_of(level, cell, Kind::Region)?);
            faces += record.faces;
            forecasts.push(record.forecast.unwrap_or_default());
        }
        if faces > self.manifest.summary.triangles {
            return Err(Error::damaged(&path, "its records have more faces than the input"));
        }
        let below: Vec<Plan> = (0..level).map(|l| self.planned(l)).collect::<Result<_, _>>()?;
        let met: usize = below.iter().map(|plan| plan.results as usize).sum();
        let targets = self.targets();
        let situation = Situation {
            level,
            cells,
            faces,
            forecasts: &forecasts,
            before: below.last().copied(),
            has_seam_strips: has_seam_strips(below.iter().rev()),
            targets: targets.get(met..).filter(|left| !left.is_empty()).ok_or_else(|| {
                Error::damaged(&path, "the levels below have all results already")
            })?,
            capacity: self.manifest.settings.capacity,
        };
        let plan = situation.plan();
        let inputs = combine(seals);
        match written {
            None => drop(self.write_sealed(&file, &inputs, &plan)?),
            Some(written) if written.content == plan && written.inputs == inputs => {}
            Some(_) => return Err(Error::damaged(&path, "this is not what its records lead to")),
        }
        Ok(plan)
    }

    /// Collapses the region of a cell as its level is planned.
    ///
    /// # Errors
    /// The region or the plan is missing or damaged, or the result cannot be written.
    pub fn reduce(&self, level: u32, cell: u32) -> Result<Record, Error> {
        if let Some(done) = self.record(level, cell, Kind::Reduced)? {
            return Ok(done);
        }
        let Next::Pass { cost_threshold, .. } = self.planned(level)?.next else {
            let path = self.folder.join(layout::plan(level));
            return Err(Error::damaged(&path, "no cells are collapsed on this level"));
        };
        if level > 0 {
            // A region that was damaged since is made again.
            self.join(level, cell)?;
        }
        self.reduce_region(self.get(level, cell, Kind::Region)?, cost_threshold)
            .map(|(record, _)| record)
    }

    /// Collapses a region, proves the distance that this causes, and writes the result.
    fn reduce_region(
        &self,
        region: Region,
        cost_threshold: CostThreshold,
    ) -> Result<(Record, Region), Error> {
        let before = self.tolerance().map(|tolerance| (region.clone(), tolerance));
        let reduced = reduce(region, &self.rules()?, cost_threshold);
        let moved = match before {
            Some((before, tolerance)) => Some(proved_distance(&before, &reduced, tolerance)?),
            None => None,
        };
        Ok((self.put(&reduced, Kind::Reduced, moved)?, reduced))
    }

    /// Joins the regions of the level below that make up a cell.
    ///
    /// # Errors
    /// One of them is missing or damaged, or the result cannot be written.
    pub fn join(&self, level: u32, cell: u32) -> Result<Record, Error> {
        if let Some(done) = self.record(level, cell, Kind::Region)? {
            return Ok(done);
        }
        let Some(below) = level.checked_sub(1) else {
            let path = self.path(level, cell, Kind::Region);
            return Err(Error::damaged(&path, "the region is not there; split the input again"));
        };
        match self.planned(below)? {
            Plan { next: Next::Pass { bits, .. }, .. } => {
                let parts = self.parts(level, cell, bits)?;
                let regions: Result<Vec<Region>, Error> =
                    parts.map(|part| self.reduced(below, part)).collect();
                self.put(&join(regions?, bits)?, Kind::Region, None)
            }
            Plan { cells, next: Next::SeamStrips { cost_threshold }, .. } => {
                self.collapse_seams(below, cells, cost_threshold)?;
                let path = self.path(level, cell, Kind::Region);
                let no_cell = || Error::damaged(&path, "there is no such cell");
                self.record(level, cell, Kind::Region)?.ok_or_else(no_cell)
            }
            _ => {
                let path = self.folder.join(layout::plan(below));
                Err(Error::damaged(&path, "nothing is joined above this level"))
            }
        }
    }

    /// Collapses the strips along the seams between the cells of a level, and writes the cells of the next level.
    fn collapse_seams(
        &self,
        level: u32,
        cells: u32,
        cost_threshold: CostThreshold,
    ) -> Result<(), Error> {
        let read = |cell| {
            if level > 0 {
                self.join(level, cell)?;
            }
            self.get(level, cell, Kind::Region)
        };
        // The cell that strips are taken from is in memory at the same time.
        let most = self.manifest.settings.capacity.region_faces / 4 * 3;
        let (strips, region) = SeamStrips::gather(level, cells, most, &self.folder, read)?.unzip();
        let region = region.unwrap_or(Region { level, ..Region::default() });
        let (_, reduced) = self.reduce_region(region, cost_threshold)?;
        for cell in 0..cells {
            let old = read(cell)?;
            let next = match &strips {
                Some(strips) => strips.put_back(&reduced, &old, &self.folder)?,
                None => Region { level: level + 1, ..old },
            };
            self.put(&next, Kind::Region, None)?;
        }
        Ok(())
    }

    /// All regions of a level as one.
    ///
    /// # Errors
    /// A region is missing or damaged, or together they are too large for indices of 32 bits.
    pub fn whole(&self, level: u32) -> Result<Region, Error> {
        let cells = self.cells(level)?;
        let regions: Result<Vec<Region>, Error> =
            (0..cells).map(|cell| self.get(level, cell, Kind::Region)).collect();
        join(regions?, cells.next_power_of_two().trailing_zeros())
    }

    /// The region of a cell of a level.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn region(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.get(level, cell, Kind::Region)
    }

    /// The region of a cell of a level that is a result.
    pub(crate) fn region_to_refine(&self, level: u32, cell: u32) -> Result<Region, Error> {
        if self.plan(level)?.results == 0 {
            let path = self.folder.join(layout::plan(level));
            return Err(Error::damaged(&path, "this level is no result"));
        }
        if level > 0 {
            self.join(level, cell)?;
        }
        self.get(level, cell, Kind::Region)
    }

    /// The record of a region that was refined.
    pub(crate) fn refined(&self, level: u32, cell: u32) -> Result<Option<Record>, Error> {
        self.record(level, cell, Kind::Refined)
    }

    pub(crate) fn put_refined(&self, region: &Region, moved: Option<f64>) -> Result<Record, Error> {
        self.put(region, Kind::Refined, moved)
    }

    /// The refined region of a cell of a result.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn refined_region(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.get(level, cell, Kind::Refined)
    }

    /// The record of a result that was made in memory.
    pub(crate) fn lod_output(&self, level: u32, number: u32) -> Result<Option<Record>, Error> {
        self.record(level, number, Kind::LodOutput)
    }

    pub(crate) fn put_lod_output(
        &self,
        output: &Region,
        moved: Option<f64>,
    ) -> Result<Record, Error> {
        self.put(output, Kind::LodOutput, moved)
    }

    /// A result that was made in memory.
    pub(crate) fn lod_output_mesh(&self, level: u32, number: u32) -> Result<TriMesh, Error> {
        let Region { positions, triangles, .. } = self.get(level, number, Kind::LodOutput)?;
        let path = self.path(level, number, Kind::LodOutput);
        TriMesh::from_triangles(&positions, &triangles)
            .map_err(|error| Error::damaged(&path, error.to_string()))
    }

    /// An upper bound of the distance between the input and the regions of a level, in model units: the largest
    /// distance over the cells of each pass, added up over the passes. `None` if distances are not proved. Infinite if
    /// the proof of a cell has failed.
    ///
    /// # Errors
    /// A record is missing or damaged.
    pub fn moved(&self, levels: u32) -> Result<Option<f64>, Error> {
        if self.manifest.settings.prove.is_none() {
            return Ok(None);
        }
        let mut sum = 0.0;
        for level in 0..levels {
            let mut largest = 0.0_f64;
            let plan = self.planned(level)?;
            // All strips are one region.
            let is_strips = matches!(plan.next, Next::SeamStrips { .. });
            for cell in 0..if is_strips { 1 } else { plan.cells } {
                let path = self.folder.join(layout::record(level, cell, Kind::Reduced));
                let missing = || Error::damaged(&path, "the record is not there");
                let record = self.read_record(level, cell, Kind::Reduced)?.ok_or_else(missing)?;
                largest = largest.max(record.moved.unwrap_or(f64::INFINITY));
            }
            sum = add_up(sum, largest);
        }
        Ok(Some(sum))
    }

    /// Removes the regions of a level that are not needed any more; their records stay.
    pub(crate) fn tidy(&self, level: u32, cells: u32) {
        for cell in 0..cells {
            let _ = fs::remove_file(self.path(level, cell, Kind::Reduced));
            if level > 0 {
                let _ = fs::remove_file(self.path(level, cell, Kind::Region));
            }
        }
    }

    /// The region of a cell after its collapses. Does the collapses if needed.
    fn reduced(&self, level: u32, cell: u32) -> Result<Region, Error> {
        self.reduce(level, cell)?;
        self.get(level, cell, Kind::Reduced)
    }

    /// Whether the region of a cell exists.
    pub(crate) fn has_region(&self, level: u32, cell: u32) -> Result<bool, Error> {
        Ok(self.record(level, cell, Kind::Region)?.is_some())
    }

    /// The plan of the highest level whose regions all exist. Regions of lower levels may have been removed.
    ///
    /// # Errors
    /// No level exists, a record is damaged, or the plan cannot be written.
    pub fn current(&self) -> Result<Plan, Error> {
        let (mut highest, mut level) = (0, 0);
        while let Some(cells) = self.cells_if_planned(level)? {
            let mut is_there = true;
            for cell in 0..cells {
                is_there = is_there && self.has_region(level, cell)?;
            }
            if is_there {
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
