//! The jobs run on every file: all commands, with usual and with extreme options.

use postconditions::{Promise, commands};
use serde_json::Value;

/// One or more runs of the program, and their outputs.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// The command and its variant.
    pub(super) name: String,
    /// The command lines, in order. `{in}` stands for the file, `{out}` for an empty folder, and `{len:X}` for X times
    /// the diagonal of the bounding box.
    pub(super) steps: Vec<String>,
    /// The expected outputs.
    pub(super) outputs: Vec<Output>,
    /// A condition on the report of the last step.
    pub(super) claim: Option<Claim>,
    /// Whether it is run again with two threads, which must not change the outputs.
    pub(super) is_repeated: bool,
    /// Whether it is inherently slow.
    pub(super) takes_long: bool,
    /// What the outputs have in common with the input.
    pub(super) promise: Option<Promise>,
    /// Whether it asks for something that does not exist, so that a usage error (exit 2) is allowed.
    pub(super) is_misuse: bool,
}

/// A file that a job writes.
#[derive(Clone, Debug)]
pub(super) struct Output {
    /// Its name in the folder; `{stem}` is the name of the input without extension.
    pub(super) file: String,
    /// Its number of faces.
    pub(super) faces: Faces,
    /// Whether it was built by `build`, and is an oriented 2-manifold of triangles.
    pub(super) is_built: bool,
}

/// The number of faces of an output.
#[derive(Clone, Debug)]
pub(super) enum Faces {
    /// The number in the report at this place.
    Reported(&'static str),
    /// The input and all levels together.
    AllLevels,
    /// The report does not contain it.
    Any,
    /// The file is not a mesh but JSON.
    Json,
    /// The file is read only by a later step.
    Opaque,
}

/// A condition on a report, given the diagonal of the input.
pub(super) type Claim = fn(&Value, f64) -> Result<(), String>;

impl Job {
    fn new(command: &str, what: &str, options: &str) -> Self {
        Self {
            name: format!("{command} {what}").trim_end().to_owned(),
            steps: vec![format!("{command} {{in}} {options}")],
            outputs: Vec::new(),
            claim: None,
            is_repeated: false,
            takes_long: false,
            promise: None,
            is_misuse: false,
        }
    }

    /// The job with a step before the others.
    fn after(mut self, step: &str) -> Self {
        self.steps.insert(0, step.to_owned());
        self
    }

    /// The job with an output that was built.
    fn builds(self, file: &str, faces: Faces) -> Self {
        self.writes(file, faces, true)
    }

    fn writes(mut self, file: &str, faces: Faces, is_built: bool) -> Self {
        self.outputs.push(Output { file: file.to_owned(), faces, is_built });
        self
    }

    fn claims(self, claim: Claim) -> Self {
        Self { claim: Some(claim), ..self }
    }

    fn repeated(self) -> Self {
        Self { is_repeated: true, ..self }
    }

    fn long(self) -> Self {
        Self { takes_long: true, ..self }
    }

    /// The first word of the name.
    pub(super) fn command(&self) -> &str {
        self.name.split(' ').next().unwrap_or_default()
    }
}

/// The command that describes a file.
pub(super) fn info() -> Job {
    Job::new("info", "", "")
}

/// All jobs except [`info`].
pub(super) fn all() -> Vec<Job> {
    let groups = [
        more_info(),
        convert(),
        repair(),
        subdivide(),
        curvature(),
        flip(),
        simplify(),
        lod(),
        patch(),
        distance(),
    ];
    groups.concat()
}

/// The number of combinations of options that chance chooses.
const COMBINED: u64 = 40;

/// The jobs that promise not to make a mesh worse in kind.
pub(super) fn promising() -> Vec<Job> {
    let in_memory = commands::all().into_iter().filter(|command| command.density <= 1.0);
    let in_memory = in_memory.chain((0..COMBINED).map(commands::combined));
    let job = |command: commands::Command| {
        let job = Job {
            steps: vec![command.line.clone()],
            promise: Some(command.promise),
            ..Job::new("", "", "")
        };
        let job = Job { name: format!("{} (promise)", command.name), ..job };
        command.outputs.iter().fold(job, |job, file| job.writes(file, Faces::Any, false))
    };
    in_memory.map(job).collect()
}

const FACES: Faces = Faces::Reported("/faces");

fn more_info() -> Vec<Job> {
    vec![
        Job::new("info", "lenient", "--lenient"),
        Job::new("info", "weld by nothing", "--weld 0"),
        Job::new("info", "weld by a hundredth", "--weld {len:0.01} --cut-non-manifold"),
        Job::new("info", "weld by everything", "--weld 1e300"),
    ]
}

fn convert() -> Vec<Job> {
    let mut jobs = Vec::new();
    for format in ["obj", "ply", "stl", "off", "gltf", "glb"] {
        let file = format!("m.{format}");
        let options = format!("-o {{out}}/{file}");
        jobs.push(Job::new("convert", format, &options).writes(&file, FACES, false));
        let job =
            Job::new("convert", &format!("{format} lenient"), &format!("{options} --lenient"));
        jobs.push(job.builds(&file, FACES));
    }
    let more = [
        ("ply text single", "m.ply", "--encoding text --precision single"),
        ("ply big-endian double", "m.ply", "--encoding big-endian --precision double"),
        ("stl text", "m.stl", "--encoding text"),
        ("off big-endian", "m.off", "--encoding big-endian"),
        ("glb weld by a tenth", "m.glb", "--weld {len:0.1}"),
        ("obj weld by everything", "m.obj", "--weld 1e300"),
    ];
    jobs.extend(more.map(|(what, file, options)| {
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("convert", what, &options).builds(file, FACES)
    }));
    jobs
}

fn repair() -> Vec<Job> {
    let job = |what: &str, file: &str, options: &str| {
        let options = format!("-o {{out}}/{file} {options}");
        Job::new("repair", what, &options).builds(file, Faces::Reported("/faces_out"))
    };
    vec![
        job("", "m.ply", "").repeated(),
        job("weld by a hundredth", "m.off", "--weld 1%"),
        job("some", "m.obj", "--drop-degenerate --drop-duplicates"),
    ]
}

fn subdivide() -> Vec<Job> {
    let job = |what: &str, file: &str, options: &str| {
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("subdivide", what, &options).builds(file, Faces::Reported("/faces_out"))
    };
    vec![
        job("", "m.ply", "").repeated(),
        job("glb", "m.glb", ""),
        job("twice", "m.obj", "--steps 2").long(),
    ]
}

fn curvature() -> Vec<Job> {
    let job = |what: &str, file: &str, options: &str| {
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("curvature", what, &options).builds(file, FACES)
    };
    vec![
        Job::new("curvature", "strict", "-o {out}/m.ply").builds("m.ply", FACES),
        job("vertex", "m.ply", "").repeated(),
        job("barycentric", "m.obj", "--area barycentric --quantity k1"),
        job("gaussian", "m.off", "--quantity gaussian --colormap magma"),
        job("willmore", "m.glb", "--quantity willmore --range 0,1"),
        job("shape-index", "m.gltf", "--quantity shape-index"),
        job("curvedness", "m.stl", "--quantity curvedness --range=-1e300,1e300"),
        job("face", "m.ply", "--estimator face").repeated(),
        job("face paper", "m.off", "--estimator face --preset paper --quantity k2"),
        job("face glb", "m.glb", "--estimator face --quantity abs-sum"),
        job("face tiny", "m.ply", "--estimator face --radius {len:1e-9}"),
        job("face huge", "m.ply", "--estimator face --radius {len:1e3}").long(),
    ]
}

fn flip() -> Vec<Job> {
    let job = |what: &str, file: &str, options: &str| {
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("flip", what, &options).builds(file, FACES)
    };
    let costs =
        ["f1", "f2", "f3", "gauss", "gauss-extrinsic", "area", "delaunay", "willmore-potential"];
    let mut jobs: Vec<Job> = costs
        .iter()
        .map(|cost| job(cost, "m.ply", &format!("--cost {cost}")).claims(cost_goes_down))
        .collect();
    jobs.extend([
        Job::new("flip", "strict", "-o {out}/m.ply --cost f2").builds("m.ply", FACES),
        job("willmore", "m.obj", "--cost willmore"),
        job("f2 repeated", "m.off", "--cost f2").repeated(),
        job("f3 barycentric", "m.glb", "--cost f3 --area barycentric"),
        job("f2 no-intersections", "m.ply", "--cost f2 --no-intersections")
            .claims(cost_goes_down)
            .long(),
        job("f2 guarded", "m.obj", "--cost f2 --feature-angle 40 --max-fold 60"),
        job("area features everywhere", "m.ply", "--cost area --feature-angle 0 --max-fold 0"),
        job("f1 look-ahead", "m.ply", "--cost f1 --look-ahead 2 --time-limit 60")
            .claims(cost_goes_down)
            .long(),
        job(
            "delaunay anneal",
            "m.ply",
            "--cost delaunay --anneal-steps 2 --seed 7 --time-limit 60",
        )
        .claims(cost_goes_down)
        .long(),
        job(
            "f2 one flip",
            "m.ply",
            "--cost f2 --max-flips 1 --random-ties --seed 18446744073709551615",
        ),
        job("f2 no time", "m.ply", "--cost f2 --time-limit 0"),
    ]);
    jobs
}

fn simplify() -> Vec<Job> {
    let faces = || Faces::Reported("/faces_out");
    let job = |what: &str, file: &str, options: &str| {
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("simplify", what, &options).builds(file, faces())
    };
    let mut jobs = Vec::new();
    for preset in [
        "draft",
        "fast",
        "default",
        "quality",
        "thin-features",
        "quadrics",
        "paper-l1",
        "paper-l2",
        "paper-l1-guarded",
    ] {
        jobs.push(job(preset, "m.ply", &format!("--ratio 0.3 --preset {preset}")));
    }
    for placement in ["optimal-volume", "optimal", "endpoint", "midpoint", "butterfly"] {
        let options = format!("--ratio 0.5 --preset fast --placement {placement}");
        jobs.push(job(placement, "m.off", &options));
    }
    jobs.extend([
        job(
            "curvature-optimal",
            "m.off",
            "--ratio 0.5 --preset paper-l1 --placement curvature-optimal",
        )
        .long(),
        Job::new("simplify", "strict", "-o {out}/m.ply --ratio 0.3").builds("m.ply", faces()),
        job("extreme", "m.ply", "--ratio 0.1 --preset extreme --anneal-time 10").long(),
        job("repeated", "m.obj", "--ratio 0.2").repeated(),
        job("glb", "m.glb", "--ratio 0.3 --attribute-weight 10"),
        job("obj without attributes", "m.obj", "--ratio 0.3 --preset fast --attribute-weight 0"),
        job("to nothing", "m.ply", "--faces 0 --preset fast"),
        job("to nothing fitted", "m.obj", "--ratio 0 --components keep"),
        job("to everything", "m.ply", "--ratio 1"),
        job("four vertices", "m.stl", "--vertices 4"),
        job("for nothing", "m.ply", "--max-cost 0"),
        job("no time", "m.ply", "--time-limit 0"),
        job("locked", "m.ply", "--ratio 0.1 --lock-boundary --feature-angle 0"),
        job("features", "m.obj", "--ratio 0.1 --feature-angle 30 --curvature-weight 1e6"),
        job("no-intersections", "m.ply", "--ratio 0.3 --no-intersections").long(),
        job("largest error", "m.ply", "--max-error {len:0.01}"),
        job("proved error", "m.ply", "--max-error {len:0.005} --verify")
            .claims(is_within_error)
            .long(),
        job("tiny error", "m.ply", "--max-error {len:1e-12} --preset fast --verify").long(),
        job("huge error", "m.obj", "--max-error {len:10} --preset fast"),
        job("fitted long", "m.ply", "--ratio 0.05 --fit-rounds 20 --seed 18446744073709551615")
            .long(),
    ]);
    jobs
}

fn lod() -> Vec<Job> {
    let job = |what: &str, options: &str| Job::new("lod", what, &format!("--lenient {options}"));
    let level = Faces::Reported;
    vec![
        job("glb", "-o {out}/m.glb --levels 0.5,0.25,0.1").builds("m.glb", Faces::AllLevels),
        job("gltf", "-o {out}/m.gltf --faces 1000,10 --preset fast").builds("m.gltf", Faces::AllLevels),
        job("folder", "-o {out} --levels 0.5,0.1 --to ply --preset fast")
            .builds("{stem}-1.ply", level("/levels/0/faces"))
            .builds("{stem}-2.ply", level("/levels/1/faces")),
        job("errors", "-o {out} --errors {len:0.001},{len:0.02} --to obj")
            .builds("{stem}-1.obj", level("/levels/0/faces"))
            .builds("{stem}-2.obj", level("/levels/1/faces"))
            .long(),
        job("record", "-o {out}/m.off --replay {out}/r.lod --faces 100")
            .after("lod {in} --lenient -o {out}/f.glb --levels 0.05 --preset fast --record {out}/r.lod")
            .writes("r.lod", Faces::Opaque, false)
            .writes("f.glb", Faces::Opaque, false)
            .builds("m.off", level("/levels/0/faces")),
        job("nothing and everything", "-o {out}/m.glb --levels 0,1 --preset paper-l2")
            .builds("m.glb", Faces::AllLevels),
    ]
}

fn patch() -> Vec<Job> {
    let job = |what: &str, file: &str, options: &str| {
        let faces = if file.ends_with("json") { Faces::Json } else { Faces::Any };
        let options = format!("-o {{out}}/{file} --lenient {options}");
        Job::new("patch", what, &options).writes(file, faces, false)
    };
    vec![
        Job::new("patch", "strict", "-o {out}/m.ply --tolerance 0.01 --relative").writes(
            "m.ply",
            Faces::Any,
            false,
        ),
        job("cover", "m.ply", "--tolerance 0.01 --relative").repeated(),
        job("record", "m.json", "--tolerance 0.02 --relative --cover greedy"),
        job("splats", "m.ply", "--tolerance 0.02 --relative --as splats --shape circle"),
        job("paper", "m.glb", "--tolerance 0.02 --relative --preset paper --shape sagitta"),
        job("no overhang", "m.obj", "--tolerance 0.02 --relative --no-overhang --cover sequential"),
        job("tiny", "m.ply", "--tolerance 1e-9 --relative"),
        job("huge", "m.off", "--tolerance 1e3 --relative").long(),
        job("one", "m.stl", "--face 0 --radius 0.05 --relative --shape ellipse"),
        job("one far too large", "m.ply", "--face 0 --radius 100 --relative"),
        job("one largest", "m.json", "--face 0 --tolerance 0.01 --relative"),
        Job {
            is_misuse: true,
            ..job("one that is not there", "m.ply", "--face 4294967295 --tolerance 0.01")
        },
    ]
}

fn distance() -> Vec<Job> {
    let job = |what: &str, options: &str| Job::new("distance", what, &format!("{{in}} {options}"));
    let simplified = |what: &str, options: &str| {
        Job::new("distance", what, &format!("{{out}}/s.ply --lenient {options}"))
            .after("simplify {in} -o {out}/s.ply --ratio 0.1 --preset fast --lenient")
            .writes("s.ply", Faces::Opaque, true)
    };
    vec![
        job("to itself", "--samples 10000").claims(is_nowhere),
        job("to itself lenient", "--samples 10000 --lenient --exact {len:0.01}").claims(is_nowhere),
        simplified("to simplified", "--samples 20000 -o {out}/m.ply")
            .builds("m.ply", FACES)
            .repeated(),
        simplified("without samples", "--samples 0 -o {out}/m.glb").builds("m.glb", FACES),
        simplified("proved", "--samples 1 --exact {len:0.001}").claims(bounds_are_bounds).long(),
    ]
}

/// A number of a report.
fn number(report: &Value, place: &str) -> Result<f64, String> {
    let found = report.pointer(place).and_then(Value::as_f64);
    found.ok_or_else(|| format!("the report has no number {place}"))
}

fn cost_goes_down(report: &Value, _: f64) -> Result<(), String> {
    let [before, after] = [number(report, "/cost_before")?, number(report, "/cost_after")?];
    // Sums in another order differ in the last digits.
    if after <= before + 1e-9 * before.abs() {
        return Ok(());
    }
    Err(format!("the cost rose from {before:e} to {after:e}"))
}

fn is_within_error(report: &Value, diagonal: f64) -> Result<(), String> {
    if number(report, "/faces_in")? == 0.0 {
        return Ok(());
    }
    let (allowed, upper) = (0.005 * diagonal, number(report, "/error/upper")?);
    if upper <= allowed { Ok(()) } else { Err(format!("error {upper:e}, allowed {allowed:e}")) }
}

fn is_nowhere(report: &Value, diagonal: f64) -> Result<(), String> {
    let max = number(report, "/max")?;
    let allowed = 1e-9 * diagonal;
    if max <= allowed { Ok(()) } else { Err(format!("it is {max:e} away from itself")) }
}

fn bounds_are_bounds(report: &Value, _: f64) -> Result<(), String> {
    let [lower, upper, sampled] = [
        number(report, "/hausdorff/lower")?,
        number(report, "/hausdorff/upper")?,
        number(report, "/max")?,
    ];
    if lower <= upper && sampled <= upper {
        return Ok(());
    }
    Err(format!("bounds {lower:e} and {upper:e}, but a sample is {sampled:e} away"))
}
