//! Numbers for names, in the order in which they are first seen.

use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};

/// Names, each once, and the place of each. A name is kept in one copy only.
#[derive(Default)]
pub(crate) struct Numbering {
    names: Vec<String>,
    /// Places by a hash that no file can foresee; a quick one of it will do for the table.
    places: HashMap<u64, u32, foldhash::fast::RandomState>,
    state: RandomState,
}

impl Numbering {
    /// The memory that a name takes, beside its bytes.
    #[cfg(feature = "obj")]
    pub(crate) const COST: u64 = 160;

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    #[cfg(feature = "obj")]
    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
    }

    /// The number of a name, and whether it is new.
    pub(crate) fn number(&mut self, name: &str) -> (u32, bool) {
        match self.find(name) {
            Ok(place) => (place, false),
            Err(hash) => {
                let place = self.names.len() as u32;
                self.places.insert(hash, place);
                self.names.push(name.to_owned());
                (place, true)
            }
        }
    }

    /// The number of a name that has been seen.
    #[cfg(feature = "obj")]
    pub(crate) fn get(&self, name: &str) -> Option<u32> {
        self.find(name).ok()
    }

    /// The place of a name, or the hash under which to put it. Another name of the same hash makes
    /// way by another attempt.
    fn find(&self, name: &str) -> Result<u32, u64> {
        let mut attempt = 0_u32;
        loop {
            let hash = self.state.hash_one((attempt, name));
            match self.places.get(&hash) {
                None => return Err(hash),
                Some(&place) if self.names[place as usize] == name => return Ok(place),
                Some(_) => attempt += 1,
            }
        }
    }
}
