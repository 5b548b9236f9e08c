//! The list of frame groups, frozen: written once and only ever added to, so that "group 17" means the same frames in every
//! process and for as long as the run's folder lives. A frame that is new comes into a group of its own kind at the end; a frame
//! that changes changes its group's recipe, never the list.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ingredients::frames_in;
use crate::base::{PhaseName, Result};
use crate::disk::frozen::{self, Damage};
use crate::disk::{Committed, Ledger, Store};
use crate::scene::frame::Frame;

/// The folder of the list in a run's store.
const FOLDER: &str = "groups";

/// The names of a group's frames, in order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Names {
    frames: Vec<String>,
}

/// The list of frame groups.
pub(super) struct Frozen {
    list: frozen::Frozen<Names>,
    damage: Option<Damage>,
    /// Groups that a damaged list no longer holds, as the units that are done remember them.
    remembered: Vec<Names>,
}

impl Frozen {
    /// Reads the list and changes nothing.
    ///
    /// # Errors
    /// A store that fails.
    pub(super) fn read(store: &Arc<dyn Store>, ledger: &Ledger) -> Result<Self> {
        let (list, damage) = frozen::Frozen::read(Arc::clone(store), FOLDER)?;
        Frozen::with(list, damage, ledger)
    }

    /// Reads the list for a run: a damaged page is set aside, and what units remember stands in for it.
    ///
    /// # Errors
    /// A store that fails.
    pub(super) fn open(store: &Arc<dyn Store>, ledger: &Ledger) -> Result<Self> {
        let (list, damage) = frozen::Frozen::open(Arc::clone(store), FOLDER)?;
        Frozen::with(list, damage, ledger)
    }

    fn with(list: frozen::Frozen<Names>, damage: Option<Damage>, ledger: &Ledger) -> Result<Self> {
        let damage = damage.or_else(|| lost_end(&list, ledger));
        let remembered = if damage.is_some() { remembered(ledger, list.items().len())? } else { Vec::new() };
        Ok(Frozen { list, damage, remembered })
    }

    /// What was wrong with the list, if anything was.
    pub(super) fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// The frames of every group, by its number. Frames of `all` that are in none come in further groups of `size`, in the order
    /// of their names.
    pub(super) fn groups(&self, all: &[Frame], size: u32) -> Vec<Names> {
        let mut groups: Vec<Names> = self.list.items().to_vec();
        groups.extend(self.remembered.iter().cloned());
        let known: BTreeSet<&str> = groups.iter().flat_map(Names::frames).collect();
        let names = all.iter().map(|frame| frame.name.as_str());
        let new: Vec<&str> = names.filter(|name| !known.contains(name)).collect();
        let names = |some: &[&str]| Names { frames: some.iter().map(|&name| name.to_owned()).collect() };
        let new: Vec<Names> = new.chunks(size.max(1) as usize).map(names).collect();
        groups.extend(new);
        groups
    }

    /// Freezes the groups: adds to the list what it lacks.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub(super) fn freeze(&mut self, all: &[Frame], size: u32) -> Result<Vec<Names>> {
        loop {
            let groups = self.groups(all, size);
            let new = groups[self.list.items().len()..].to_vec();
            if new.is_empty() {
                return Ok(groups);
            }
            self.remembered.clear();
            match self.list.add(new)? {
                Committed::Now => return Ok(groups),
                // Another process was first: what its page lacks comes after it.
                Committed::Already => {}
            }
        }
    }
}

impl Names {
    /// The names.
    pub(super) fn frames(&self) -> impl Iterator<Item = &str> {
        self.frames.iter().map(String::as_str)
    }
}

/// The damage of a list that lacks pages at its end: units that are done are of groups that it does not hold.
fn lost_end(list: &frozen::Frozen<Names>, ledger: &Ledger) -> Option<Damage> {
    let numbers = ledger.of_phase(PhaseName::Cast).into_iter().filter_map(|unit| ledger.what(&unit)?.parse().ok());
    let beyond = numbers.max().is_some_and(|last: usize| last >= list.items().len());
    let why = || "it is not there, but units of its groups are".to_owned();
    beyond.then(|| Damage { page: list.next_page(), why: why(), kept: Vec::new() })
}

/// The groups from number `first` on, as the units of casting remember them, up to the first that no unit remembers.
fn remembered(ledger: &Ledger, first: usize) -> Result<Vec<Names>> {
    let mut groups: BTreeMap<usize, Names> = BTreeMap::new();
    for unit in ledger.of_phase(PhaseName::Cast) {
        let recipe = ledger.recipe(&unit)?;
        if let Ok(number) = recipe.what().parse::<usize>() {
            groups.insert(number, Names { frames: frames_in(&recipe).map(str::to_owned).collect() });
        }
    }
    Ok((first..).map_while(|number| groups.remove(&number)).collect())
}
