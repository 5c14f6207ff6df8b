//! Meshes that exceed the memory limit.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::{code, curvmesh, json, write};
use mesh_shapes::Torus;

/// A torus of 100,000 faces.
fn torus(folder: &Path) -> PathBuf {
    let input = folder.join("in.ply");
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(500, 100).unwrap(), &input);
    input
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

const TARGET: [&str; 4] = ["--ratio", "0.02", "--memory", "32MiB"];

#[test]
fn in_one_go_step_by_step_and_killed_in_between_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let at = |name: &str| folder.path().join(name);
    let [whole, steps, killed, work] = ["whole.ply", "steps.ply", "killed.ply", "work"].map(at);

    let report = json(&[&["simplify", text(&input), "-o", text(&whole)], &TARGET[..]].concat());
    assert_eq!((&report["faces_in"], &report["faces_out"]), (&100_000.into(), &2000.into()));
    assert!(report["passes"]["cells"][0].as_u64().unwrap() >= 4, "{report}");
    assert!(!at("whole.ply.work").exists());
    let bytes = std::fs::read(&whole).unwrap();

    let split = ["region", "split", text(&input), "-w", text(&work)];
    let mut plan = json(&[&split[..], &TARGET[..]].concat());
    assert_eq!([&plan["settings"], &plan["regions"]], [&report["settings"], &report["regions"]]);
    while plan["next"] == "pass" {
        let level = plan["level"].as_u64().unwrap();
        // In any order, and in shards.
        for shard in ["2/3", "3/3", "1/3", "2/3"] {
            let level = level.to_string();
            json(&["region", "reduce", text(&work), "--level", &level, "--shard", shard]);
        }
        json(&["region", "join", text(&work), "--level", &(level + 1).to_string()]);
        plan = json(&["region", "plan", text(&work)]);
    }
    json(&["region", "finish", text(&work), "-o", text(&steps)]);
    assert!(bytes == std::fs::read(&steps).unwrap());

    // Killed repeatedly, later each time.
    let go_on =
        [&["simplify", text(&input), "-o", text(&killed), "--resume"], &TARGET[..]].concat();
    for round in 1..6 {
        let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        let mut run = run.args(&go_on).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(130 * round));
        run.kill().unwrap();
        run.wait().unwrap();
    }
    let output = curvmesh(&go_on);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(bytes == std::fs::read(&killed).unwrap());
}

#[test]
fn what_needs_the_whole_mesh_is_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let [output, work] = ["out.ply", "work"].map(|name| folder.path().join(name));
    let simplify = ["simplify", text(&input), "-o", text(&output), "--memory", "32MiB"];
    for more in [
        &["--max-error", "1%"][..],
        &["--ratio", "0.1", "--feature-angle", "30"],
        &["--ratio", "0.1", "--lock-boundary"],
        &["--ratio", "0.1", "--no-intersections"],
        &["--ratio", "0.1", "--preset", "paper-l1"],
        &["--ratio", "0.1", "--weld", "exact"],
        &["--ratio", "0.1", "--labels", "part"],
        &["--ratio", "0.1", "--blend", "part"],
        &["--ratio", "0.1", "--view", "page.html"],
    ] {
        let (code, message) = code(&[&simplify[..], more].concat());
        assert!(code == 2 && !output.exists(), "{more:?}: {code} {message}");
    }
    let (least, message) = code(&[
        "simplify",
        text(&input),
        "-o",
        text(&output),
        "--ratio",
        "0.1",
        "--memory",
        "1MiB",
    ]);
    assert!(least == 2 && message.contains("allow at least"), "{message}");
    // A mesh that fits is simplified as without the option.
    for (name, memory) in [("a.ply", None), ("b.ply", Some("1G"))] {
        let there = folder.path().join(name);
        let mut arguments = vec!["simplify", text(&input), "-o", text(&there), "--ratio", "0.02"];
        arguments.extend(memory.iter().flat_map(|memory| ["--memory", memory]));
        assert_eq!(code(&arguments).0, 0);
    }
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read("a.ply") == read("b.ply"));
    // A folder with other files is refused as well.
    let run = [&["simplify", text(&input), "-o", text(&output)], &TARGET[..]].concat();
    assert_eq!(code(&[&run[..], &["--work-dir", text(folder.path())]].concat()).0, 2);
    // A folder of another run is not changed.
    assert_eq!(code(&[&run[..], &["--work-dir", text(&work)]].concat()).0, 0);
    assert_eq!(code(&[&run[..], &["--work-dir", text(&work)]].concat()).0, 2);
    assert_eq!(code(&[&run[..], &["--work-dir", text(&work), "--resume"]].concat()).0, 0);
    let other = [&run[..], &["--work-dir", text(&work), "--resume", "--preset", "fast"]].concat();
    assert_eq!(code(&other).0, 2);
}

#[test]
fn invalid_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.ply");
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let cases = [
        ("short.ply", format!("{header}0 0 0\n"), 3),
        ("index.ply", format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"), 3),
        ("nan.ply", format!("{header}0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"), 3),
        ("twice.ply", format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 1\n"), 4),
        ("huge.ply", header.replace("vertex 3", "vertex 3000000000"), 3),
        ("facets.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n".to_owned(), 3),
        ("lines.obj", "v 0 0 0\nf 1 2 9\n".to_owned(), 3),
        ("off.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n".to_owned(), 3),
        ("nothing.ply", String::new(), 3),
    ];
    for (name, content, expected) in cases {
        let input = folder.path().join(name);
        std::fs::write(&input, content).unwrap();
        // With the single steps, which always use regions.
        let work = folder.path().join("work");
        let split = ["region", "split", text(&input), "-w", text(&work), "--faces", "1"];
        let (code, message) = code(&[&split[..], &["--memory", "64MiB", "--strict"]].concat());
        assert!(code == expected && !output.exists(), "{name}: {code} {message}");
        assert!(!work.join("run.json").exists());
        std::fs::remove_dir_all(work).ok();
    }
}

/// The peak of the resident memory of a run, as the system counts it.
#[cfg(target_os = "linux")]
#[test]
fn a_run_stays_within_its_memory() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.ply");
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(1000, 200).unwrap(), &input);
    let output = folder.path().join("out.ply");
    let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
    run.args([&["simplify", text(&input), "-o", text(&output)], &TARGET[..]].concat());
    let mut run = run.stdout(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", run.id());
    let mut most = 0;
    while run.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kibibytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        most = most.max(kibibytes.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(run.wait().unwrap().success());
    assert!(most > 0 && most < 40 * 1024, "{most} KiB where 32 MiB are allowed");
}

#[test]
fn a_result_that_does_not_fit_is_finished_in_parts_and_as_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let at = |name: &str| folder.path().join(name);
    let [whole, steps, tiles, work] = ["whole.ply", "steps.ply", "tiles", "work"].map(at);
    let target = ["--ratio", "0.5", "--memory", "32MiB"];
    let report = json(&[&["simplify", text(&input), "-o", text(&whole)], &target[..]].concat());
    let faces = report["faces_out"].as_u64().unwrap();
    assert!(faces.abs_diff(50_000) < 500, "{report}");

    let split = ["region", "split", text(&input), "-w", text(&work)];
    let mut plan = json(&[&split[..], &target[..]].concat());
    let early = code(&["region", "finish", text(&work), "--shard", "1/2"]);
    assert_eq!(early.0, 2, "{}", early.1);
    while plan["next"] != "finish" {
        let level = plan["level"].as_u64().unwrap();
        if plan["next"] == "pass" {
            json(&["region", "reduce", text(&work), "--level", &level.to_string()]);
        }
        json(&["region", "join", text(&work), "--level", &(level + 1).to_string()]);
        plan = json(&["region", "plan", text(&work)]);
    }
    let apart = plan["apart"].as_u64().unwrap();
    assert!(apart > 1, "{plan}");
    let mut finished = 0;
    for shard in ["2/2", "1/2"] {
        let report = json(&["region", "finish", text(&work), "--shard", shard]);
        finished += report["faces"].as_u64().unwrap();
    }
    assert_eq!(finished, faces);
    let report =
        json(&["region", "finish", text(&work), "-o", text(&steps), "--tiles", text(&tiles)]);
    assert!(std::fs::read(&whole).unwrap() == std::fs::read(&steps).unwrap());
    assert_eq!(report["tiles"][1], apart);
    let list = std::fs::read_to_string(tiles.join("tiles.json")).unwrap();
    let list: serde_json::Value = serde_json::from_str(&list).unwrap();
    assert_eq!(list["faces"], faces);
    let sum = |key: &str| -> u64 {
        list["tiles"].as_array().unwrap().iter().map(|tile| tile[key].as_u64().unwrap()).sum()
    };
    assert_eq!(sum("faces"), faces);
    // Vertices on common borders are in several tiles.
    let info = json(&["info", text(&steps)]);
    assert!(sum("vertices") > info["vertices"].as_u64().unwrap());
    assert_eq!((&info["euler_characteristic"], &info["closed"]), (&0.into(), &true.into()));
    // Without an output there is nothing to do.
    assert_eq!(code(&["region", "finish", text(&work)]).0, 2);
    let cell = apart.to_string();
    assert_eq!(code(&["region", "finish", text(&work), "--cell", &cell]).0, 2);
}

#[test]
fn levels_in_one_go_step_by_step_and_killed_in_between_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let at = |name: &str| folder.path().join(name);
    let [whole, steps, killed, work] = ["whole", "steps", "killed", "work"].map(at);
    let levels = ["--levels", "0.02,0.5,0.05", "--memory", "32MiB"];
    let files = |folder: &Path| {
        [1, 2, 3].map(|level| std::fs::read(folder.join(format!("in-{level}.ply"))).unwrap())
    };

    let lod = ["lod", text(&input), "-o", text(&whole)];
    let report = json(&[&lod[..], &levels, &["--verify"]].concat());
    assert!(report["passes"]["cells"][0].as_u64().unwrap() >= 4, "{report}");
    assert!(!at("whole.work").exists());
    for (level, target) in report["levels"].as_array().unwrap().iter().zip([50_000, 5000, 2000]) {
        let faces = level["faces"].as_u64().unwrap();
        assert!(faces.abs_diff(target) <= target / 100, "{level}");
        let file = level["output"].as_str().unwrap();
        let info = json(&["info", file]);
        assert_eq!(info["faces"].as_u64(), Some(faces));
        assert_eq!((&info["euler_characteristic"], &info["closed"]), (&0.into(), &true.into()));
        let measured = json(&["distance", text(&input), file, "--samples", "20000"]);
        assert!(measured["max"].as_f64() <= level["error"].as_f64(), "{level} {measured}");
    }
    let expected = files(&whole);

    let split = ["region", "split", text(&input), "-w", text(&work), "--verify"];
    let mut plan = json(&[&split[..], &levels].concat());
    let mut apart = 0;
    loop {
        let level = plan["level"].as_u64().unwrap();
        let [this, next] = [level, level + 1].map(|level| level.to_string());
        if !plan["apart"].is_null() {
            apart += 1;
            for shard in ["2/2", "1/2"] {
                let cells = ["--level", &this, "--shard", shard];
                json(&[&["region", "finish", text(&work)], &cells[..]].concat());
            }
        }
        if plan["next"] == "finish" {
            break;
        }
        if plan["next"] == "pass" {
            json(&["region", "reduce", text(&work), "--level", &this]);
        }
        json(&["region", "join", text(&work), "--level", &next]);
        plan = json(&["region", "plan", text(&work)]);
    }
    assert_eq!(apart, 1);
    let last = plan["level"].to_string();
    let none = ["region", "finish", text(&work), "--level", "0", "--cell", "0"];
    assert!(code(&none).1.contains("level 0 is no result"), "{last}");
    let tiles = at("tiles");
    let report =
        json(&["region", "finish", text(&work), "-o", text(&steps), "--tiles", text(&tiles)]);
    assert_eq!(report["levels"].as_array().unwrap().len(), 6);
    assert!(files(&steps) == expected);
    for (level, faces) in [1, 2, 3].into_iter().zip(report["levels"].as_array().unwrap()) {
        let list = std::fs::read_to_string(tiles.join(format!("in-{level}/tiles.json"))).unwrap();
        let list: serde_json::Value = serde_json::from_str(&list).unwrap();
        assert_eq!(list["faces"], faces["faces"]);
    }
    // The result is complete, even after intermediate files were removed.
    assert_eq!(json(&["region", "plan", text(&work)])["level"].to_string(), last);
    json(&[
        "lod",
        text(&input),
        "-o",
        text(&at("again")),
        "--levels",
        "0.5,0.05",
        "--memory",
        "32MiB",
        "--tiles",
    ]);
    assert!(at("again/in-1/tiles.json").exists() && at("again/in-2/tile-0.ply").exists());

    let go_on = ["lod", text(&input), "-o", text(&killed), "--resume", "--verify"];
    let go_on = [&go_on[..], &levels].concat();
    for round in 1..6 {
        let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        let mut run = run.args(&go_on).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(200 * round));
        run.kill().unwrap();
        run.wait().unwrap();
    }
    let output = curvmesh(&go_on);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(files(&killed) == expected);
}

#[test]
fn levels_that_need_the_whole_mesh_are_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let output = folder.path().join("levels");
    let lod = ["lod", text(&input), "-o", text(&output), "--memory", "32MiB"];
    for more in [
        &["--errors", "1%"][..],
        &["--levels", "0.1", "--record", "run.lod"],
        &["--faces", "90", "--view", "page.html"],
        &["--faces", "90", "--fit-rounds", "3"],
        &["--faces", "90", "--attribute-weight", "1"],
        &["--faces", "90", "--lock-boundary"],
        &["--faces", "90", "--tiles", "--precision", "single"],
        // Detected only after the file is split.
        &["--levels", "0.5,0.1", "--to", "obj"],
    ] {
        let (code, message) = code(&[&lod[..], more].concat());
        assert!(code == 2 && !output.exists(), "{more:?}: {code} {message}");
        assert!(!folder.path().join("levels.work").exists(), "{more:?}");
    }
    let small = folder.path().join("small.ply");
    let simplify =
        ["simplify", text(&input), "-o", text(&small), "--faces", "90", "--memory", "32MiB"];
    for more in [&["--normal-weight", "1"][..], &["--keep-creases"], &["--view", "page.html"]] {
        assert!(code(&[&simplify[..], more].concat()).0 == 2 && !small.exists(), "{more:?}");
    }
    let one = folder.path().join("levels.glb");
    let (code_of_one, message) =
        code(&["lod", text(&input), "-o", text(&one), "--faces", "90", "--memory", "32MiB"]);
    assert!(code_of_one == 2 && message.contains("folder"), "{message}");
    let work = folder.path().join("work");
    let split = ["region", "split", text(&input), "-w", text(&work), "--memory", "32MiB"];
    for more in [&["--levels", "0.5", "--faces", "90"][..], &["--level-faces", "9", "--norm", "l1"]]
    {
        assert_eq!(code(&[&split[..], more].concat()).0, 2, "{more:?}");
    }
    // A mesh that fits gives the same levels as without the option, and with tiles each level is a single tile.
    let [a, b, c] = ["a", "b", "c"].map(|name| folder.path().join(name));
    for (to, memory) in
        [(&a, &[][..]), (&b, &["--memory", "1G"]), (&c, &["--memory", "1G", "--tiles"])]
    {
        json(&[&["lod", text(&input), "-o", text(to), "--faces", "900,90"][..], memory].concat());
    }
    let read = |folder: &Path| std::fs::read(folder.join("in-2.ply")).unwrap();
    // One level is one file in a folder, or a file.
    json(&[&split[..], &["--levels", "0.01"]].concat());
    let [d, e] = ["d", "e.obj"].map(|name| folder.path().join(name));
    for to in [&d, &e] {
        json(&["region", "finish", text(&work), "-o", text(to)]);
    }
    assert!(d.join("in-1.ply").exists() && e.exists());
    assert!(read(&a) == read(&b) && c.join("in-1/tile-0.ply").exists());
}
