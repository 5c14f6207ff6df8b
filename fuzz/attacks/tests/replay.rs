//! Runs every attack with its stored bytes: the findings and the seeds of the fuzzer.

use std::panic::catch_unwind;
use std::path::Path;

use attacks::ALL;

#[test]
fn the_corpus_breaks_no_promise() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus");
    let mut broken = Vec::new();
    for &(name, attack) in ALL {
        let mut inputs = 0;
        for entry in std::fs::read_dir(corpus.join(name)).expect("every attack has a corpus") {
            let path = entry.expect("the folder can be listed").path();
            let data = std::fs::read(&path).expect("an input can be read");
            inputs += 1;
            if catch_unwind(|| attack(&data)).is_err() {
                broken.push(format!("{name}/{}", path.file_name().unwrap_or_default().display()));
            }
        }
        assert!(inputs > 0, "{name} has no input");
    }
    assert!(broken.is_empty(), "broken by {}", broken.join(", "));
}

#[test]
fn bytes_without_meaning_break_no_promise() {
    for &(_, attack) in ALL {
        for length in [0, 1, 2, 7, 64, 500] {
            for start in 0..4_u64 {
                // Bytes of a linear congruential generator.
                let mut state = start;
                let data: Vec<u8> = (0..length)
                    .map(|_| {
                        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        (state >> 56) as u8
                    })
                    .collect();
                attack(&data);
            }
        }
    }
}

#[test]
fn every_attack_is_a_target() {
    let targets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz_targets");
    for (name, _) in ALL {
        assert!(targets.join(format!("{name}.rs")).is_file(), "{name} is no target");
    }
}
