//! Numbers for names, in the order of first occurrence.

use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};

use mesh_core::as_u32;

/// Unique names, and the number of each. Every name is stored once.
#[derive(Default)]
pub(crate) struct Numbering {
    names: Vec<String>,
    /// Numbers by a hash that a file cannot predict; the table uses a fast hash of it.
    places: HashMap<u64, u32, foldhash::fast::RandomState>,
    state: RandomState,
}

impl Numbering {
    /// The memory of a name, in addition to its bytes.
    #[cfg(feature = "obj")]
    pub(crate) const COST: u64 = 160;

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    #[cfg(feature = "obj")]
    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
    }

    /// The number of a name, and whether the name is new.
    pub(crate) fn number(&mut self, name: &str) -> (u32, bool) {
        match self.find(name) {
            Ok(place) => (place, false),
            Err(hash) => {
                let place = as_u32(self.names.len());
                self.places.insert(hash, place);
                self.names.push(name.to_owned());
                (place, true)
            }
        }
    }

    /// The number of a known name.
    #[cfg(feature = "obj")]
    pub(crate) fn get(&self, name: &str) -> Option<u32> {
        self.find(name).ok()
    }

    /// The number of a name, or the hash to store it under. If another name has the same hash, another attempt follows.
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
