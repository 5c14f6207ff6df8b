//! Every option that is a count has an upper bound, or any value ends at once.
#![allow(clippy::unwrap_used)]

use crate::common::{code, write};
use mesh_shapes::Torus;

/// Without a bound, these runs would start any number of threads, take any amount of memory or make any number of
/// rounds.
#[test]
fn counts_beyond_their_bounds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] =
        ["in.ply", "out.ply"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    write(Torus { major: 5.0, minor: 2.0 }.mesh(12, 8).unwrap(), input.as_ref());
    let flip = ["flip", &input, "-o", &output, "--cost", "f2"];
    let cases: [(&[&str], &str); 9] = [
        (&["info", &input], "--threads"),
        (&["simplify", &input, "-o", &output, "--faces", "50"], "--fit-rounds"),
        (&["distance", &input, &input], "--samples"),
        (&["curvature", &input, "--estimator", "fit"], "--rings"),
        (&["subdivide", &input, "-o", &output], "--steps"),
        (&flip, "--look-ahead"),
        (&flip, "--anneal-steps"),
        (&flip, "--rebuild-effort"),
        (&[&flip[..], &["--rebuild-effort", "1"]].concat(), "--rebuild-largest"),
    ];
    for (arguments, option) in cases {
        for count in ["18446744073709551615", "1000000000000"] {
            let (code, message) = code(&[arguments, &[option, count]].concat());
            assert_eq!(code, 2, "{option} {count}: {message}");
            assert!(message.contains("expected a number"), "{option} {count}: {message}");
        }
    }
}

/// Every option that is a number, with values at the ends of all types: the answer is a result, or the name of the
/// option and what it takes.
#[test]
fn numbers_at_the_ends_of_their_types_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] =
        ["in.ply", "out.ply"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    write(Torus { major: 5.0, minor: 2.0 }.mesh(12, 8).unwrap(), input.as_ref());
    let work = folder.path().join("work").to_str().unwrap().to_owned();
    let simplify = ["simplify", &input, "-o", &output];
    let flip = ["flip", &input, "-o", &output];
    let cases: [(&[&str], &str); 15] = [
        (&simplify, "--vertices"),
        (&simplify, "--faces"),
        (&simplify, "--max-valence"),
        (&simplify, "--components"),
        (&simplify, "--seed"),
        (&simplify, "--time-limit"),
        (&flip, "--max-flips"),
        (&flip, "--time-limit"),
        (&["patch", &input, "-o", &output, "--tolerance", "1%"], "--face"),
        (&["repair", &input, "-o", &output], "--fill-holes"),
        (&["view", &input, "-o", &output.replace("ply", "html")], "--most-faces"),
        (&["render", &input, "-o", &output.replace("ply", "png")], "--supersampling"),
        (&["region", "reduce", &work], "--level"),
        (&["region", "reduce", &work, "--level", "0"], "--cell"),
        (&["info", &input], "--max-memory"),
    ];
    for (arguments, option) in cases {
        for number in ["9223372036854775808", "18446744073709551615", "-1", "1e400", "", "0x10"] {
            let value = format!("{option}={number}");
            let words = [arguments, &[value.as_str()]].concat();
            let (code, message) = code(&words);
            assert!([0, 2, 3, 4].contains(&code), "{option} {number}: {message}");
            let tells = message.contains(option) && message.contains("expected ");
            assert!(code != 2 || tells, "{option} {number}: {message}");
        }
    }
}
