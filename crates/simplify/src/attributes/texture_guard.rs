//! The texture does not fold over.

use std::cell::RefCell;
use std::rc::Rc;

use glam::DVec3;

use crate::attributes::wedges::CornerAttributes;
use crate::collapse::guard::Guard;
use crate::collapse::patch::EdgePatch;
use crate::collapse::refusal::Refusal;

/// Refuses collapses after which a face would lie the other way round in the texture, or have no
/// area there.
pub struct TextureGuard {
    attributes: Rc<RefCell<CornerAttributes>>,
}

impl TextureGuard {
    /// A guard that looks at attributes that the cost of the same run keeps up to date.
    #[must_use]
    pub fn new(attributes: Rc<RefCell<CornerAttributes>>) -> Self {
        Self { attributes }
    }
}

impl Guard for TextureGuard {
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal> {
        if self.attributes.borrow().folds(patch, x) { Err(Refusal::TextureFold) } else { Ok(()) }
    }
}
