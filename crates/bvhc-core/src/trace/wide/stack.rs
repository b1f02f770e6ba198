//! Children that wait to be entered.

use crate::layout::MAX_DEPTH;
use std::mem::MaybeUninit;

/// A child put off, or taken up: its entry distance and its links.
#[derive(Clone, Copy)]
pub struct Pending {
    pub near: f32,
    pub first: u32,
    pub count: u32,
}

/// As many as may wait in any tree: seven of each level that a binary tree may have, and all of the node that is entered.
const MOST: usize = 7 * MAX_DEPTH as usize + 8;

/// The farthest at the bottom. Places are not written before they are used, since each ray would feel that.
pub struct Stack {
    /// Those below `height` were written.
    places: [MaybeUninit<Pending>; MOST],
    height: usize,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Stack {
        Stack { places: [const { MaybeUninit::uninit() }; MOST], height: 0 }
    }

    #[inline(always)]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Take the child on top.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Pending> {
        let top = self.below(self.height)?;
        self.height -= 1;
        Some(top)
    }

    /// Put a child among those from `base` on, the nearest on top. Of equals the first is on top: what `comes_first` lies above its equals, what does not, below
    /// them. False where no place is left.
    #[inline(always)]
    #[must_use]
    pub fn put(&mut self, base: usize, waits: Pending, comes_first: bool) -> bool {
        if self.height >= MOST {
            return false;
        }
        let mut at = self.height;
        while at > base
            && let Some(below) = self.below(at)
            && (below.near < waits.near || (!comes_first && below.near == waits.near))
        {
            self.places[at] = MaybeUninit::new(below);
            at -= 1;
        }
        self.places[at] = MaybeUninit::new(waits);
        self.height += 1;
        true
    }

    /// The child below a place, if that is at most as high as the stack.
    #[inline(always)]
    #[allow(unsafe_code)]
    fn below(&self, at: usize) -> Option<Pending> {
        if at == 0 || at > self.height {
            return None;
        }
        // SAFETY: the place is below `height`. Only `put` makes the stack higher, by one, after it wrote the place there used to be on top, or moved what was
        // written one place up to there and wrote below it; `pop` makes it lower.
        self.places.get(at - 1).map(|place| unsafe { place.assume_init() })
    }
}
