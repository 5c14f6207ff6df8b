//! `cargo run -p attacks --example storm -- [SECONDS] [ATTACK...]`: attacks with mutated inputs of the corpus, on
//! stable Rust and without coverage feedback.
//!
//! The fuzzer (`fuzz/README.md`) finds more, since it knows which code an input reaches. This program needs only the
//! dependencies of the tests. The first input that breaks a promise at a given place of the code is kept in
//! `target/storm`.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::BTreeSet;
use std::panic::{catch_unwind, set_hook};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use attacks::{ALL, Attack};

/// An attack that takes longer than this is an error as well.
const PATIENCE: Duration = Duration::from_secs(30);

/// Inputs do not grow beyond this.
const LONGEST: usize = 4096;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let seconds = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(10);
    let wanted: Vec<String> = arguments.collect();
    let kept = Path::new("target/storm");
    if let Err(error) = std::fs::create_dir_all(kept) {
        eprintln!("cannot make {}: {error}", kept.display());
        return ExitCode::FAILURE;
    }
    let mut faults = 0;
    for &(name, attack) in ALL {
        if wanted.is_empty() || wanted.iter().any(|word| word == name) {
            faults += storm(name, attack, Duration::from_secs(seconds), kept);
        }
    }
    if faults == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The place of the last broken promise.
static PLACE: Mutex<String> = Mutex::new(String::new());

fn storm(name: &str, attack: Attack, time: Duration, kept: &Path) -> usize {
    set_hook(Box::new(|panic| {
        let place = panic.location().map_or_else(String::new, ToString::to_string);
        let text = format!("{place}: {}", panic.payload_as_str().unwrap_or_default());
        *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = text;
    }));
    let corpus = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus").join(name));
    let words = words(name);
    let current = Arc::new(Mutex::new((Vec::new(), Instant::now())));
    watch(name, &current, kept.join(format!("{name}-hangs")));
    let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ name.len() as u64);
    let mut places = BTreeSet::new();
    let (start, mut executions) = (Instant::now(), 0_u64);
    while start.elapsed() < time {
        let mut data = change(&corpus, &words, &mut random);
        data.truncate(LONGEST);
        *current.lock().unwrap_or_else(PoisonError::into_inner) = (data.clone(), Instant::now());
        executions += 1;
        if catch_unwind(|| attack(&data)).is_ok() {
            continue;
        }
        let text = PLACE.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let place: String = text.split(": ").next().unwrap_or_default().to_owned();
        if places.insert(place) {
            let path = kept.join(format!("{name}-{}", places.len()));
            let text: String = text.chars().take(300).collect();
            println!("{name}: {text}\n    kept as {}", path.display());
            if let Err(error) = std::fs::write(&path, &data) {
                eprintln!("cannot write {}: {error}", path.display());
            }
        }
    }
    println!("{name}: {executions} executions in {} s", start.elapsed().as_secs());
    places.len()
}

/// Ends the process and keeps the input if an attack does not terminate.
fn watch(name: &str, current: &Arc<Mutex<(Vec<u8>, Instant)>>, path: PathBuf) {
    let (name, current) = (name.to_owned(), Arc::downgrade(current));
    std::thread::spawn(move || {
        while let Some(shared) = current.upgrade() {
            let guard = shared.lock().unwrap_or_else(PoisonError::into_inner);
            if guard.1.elapsed() > PATIENCE {
                println!("{name}: hangs; kept as {}", path.display());
                let _ = std::fs::write(&path, &guard.0);
                std::process::exit(1);
            }
            drop(guard);
            drop(shared);
            std::thread::sleep(Duration::from_secs(1));
        }
    });
}

fn files(folder: &Path) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().filter_map(|path| std::fs::read(path).ok()).collect()
}

/// The words of the dictionary of a format, without their escapes.
fn words(name: &str) -> Vec<Vec<u8>> {
    let format = name.trim_start_matches("read_");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dictionaries");
    let text = std::fs::read_to_string(folder.join(format!("{format}.dict"))).unwrap_or_default();
    let quoted = text.lines().filter_map(|line| line.strip_prefix('"')?.strip_suffix('"'));
    let plain = quoted.map(|word| word.replace("\\x0a", "\n").replace("\\x0d", "\r"));
    plain.map(|word| word.replace("\\\"", "\"").replace("\\\\", "\\").into_bytes()).collect()
}

/// An input of the corpus with up to eight mutations.
fn change(corpus: &[Vec<u8>], words: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut data = random.of(corpus).cloned().unwrap_or_default();
    for _ in 0..=random.below(8) {
        let at = random.below(data.len() + 1);
        let end = (at + 1 + random.below(16)).min(data.len());
        match random.below(9) {
            0 if at < data.len() => data[at] ^= 1 << random.below(8),
            1 if at < data.len() => data[at] = random.next() as u8,
            2 => data.insert(at, random.next() as u8),
            3 => drop(data.drain(at.min(end)..end)),
            4 => {
                let copy = data[at.min(end)..end].to_vec();
                let to = random.below(data.len() + 1);
                data.splice(to..to, copy);
            }
            5 => {
                let other = random.of(corpus).cloned().unwrap_or_default();
                let from = random.below(other.len() + 1);
                data.truncate(at);
                data.extend_from_slice(&other[from..]);
            }
            6 => {
                let number =
                    *random.of(&[0, 1, 0x7F, 0x80, 0xFF, 0xFFFF, u32::MAX, 1 << 31]).unwrap_or(&0);
                let to = (at + 4).min(data.len());
                data.splice(at.min(to)..to, number.to_le_bytes());
            }
            7 => {
                let word =
                    random.of(words).cloned().unwrap_or_else(|| vec![random.next() as u8; 3]);
                data.splice(at..at, word);
            }
            _ => {
                let fresh: Vec<u8> = (0..random.below(40)).map(|_| random.next() as u8).collect();
                data.splice(at.min(end)..end, fresh);
            }
        }
    }
    data
}

/// Marsaglia's xorshift with a multiplication at the end.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 32
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }
}
