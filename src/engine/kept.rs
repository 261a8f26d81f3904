//! What threads keep between blocks and passes, so that nothing is allocated for a chunk. What is
//! computed with it is not its business.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

use crate::campaign::run::Samples;
use crate::engine::gauss_markov::Filtering;
use crate::engine::lanes::products::Products;
use crate::engine::lanes::{Code, Lanes, Workspace};
use crate::engine::mixing::Mixing;
use crate::engine::problem::Problem;

/// What one thread keeps between blocks.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// One for each campaign: it serves one program of it.
    pub(super) own: Vec<Option<Own>>,
    pub(super) weights: Vec<Lanes>,
    pub(super) filtering: Filtering,
    /// Of a run that is not in memory as it is looked at.
    pub(super) samples: Samples,
}

/// What one thread keeps between the blocks of a campaign.
#[derive(Debug)]
pub(super) struct Own {
    pub(super) workspace: Workspace,
    pub(super) mixed: Mixing,
    /// Of each row; made where they are wanted.
    pub(super) products: Vec<Products>,
}

impl Memory {
    /// What is kept for a campaign, once something of it was computed.
    pub(super) fn own(&mut self, part: usize) -> Option<&mut Own> {
        self.own.get_mut(part).and_then(Option::as_mut)
    }
}

/// What threads keep between passes of one program a campaign.
#[derive(Debug, Default)]
pub(super) struct Memories(Mutex<Vec<Memory>>);

/// The memory of a thread, which goes back when it is dropped.
pub(super) struct Lent<'a> {
    memory: Memory,
    owner: &'a Memories,
}

impl Memories {
    pub(super) fn lend(&self) -> Lent<'_> {
        let memory = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lent { memory: memory.unwrap_or_default(), owner: self }
    }
}

impl Deref for Lent<'_> {
    type Target = Memory;

    fn deref(&self) -> &Memory {
        &self.memory
    }
}

impl DerefMut for Lent<'_> {
    fn deref_mut(&mut self) -> &mut Memory {
        &mut self.memory
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let memory = std::mem::take(&mut self.memory);
        self.owner.0.lock().unwrap_or_else(PoisonError::into_inner).push(memory);
    }
}

impl Problem {
    /// What a thread keeps for a campaign, made where it is not there yet.
    pub(super) fn own<'m>(&self, part: usize, code: &Code, memory: &'m mut Memory) -> &'m mut Own {
        memory.own.resize_with(memory.own.len().max(self.parts.len()), || None);
        memory.own[part].get_or_insert_with(|| Own {
            workspace: Workspace::new(code, self.set),
            mixed: Mixing::default(),
            products: Vec::new(),
        })
    }
}
