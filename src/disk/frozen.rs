//! A list that is written once and only ever added to, as the groups of a run are: what was in it stays, in its order.
//! The list `groups` lies in pages, `groups/000000.json`, `groups/000001.json`, .., each sealed JSON (`sealed_json`):
//!
//! ```text
//! version    1
//! checksum   BLAKE3 in hex of `items`
//! items      [ ITEM, .. ]
//! ```
//!
//! A page is created whole, first wins. So of several processes that add to the list, one adds each page, and all read
//! the same list. Without a page, the pages after it mean nothing: the list ends before it.

use std::collections::BTreeSet;
use std::io::Write;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::corrupt;
use super::names::Committed;
use super::sealed_json::{JsonSeal, Unreadable};
use super::store::Store;
use crate::base::{Error, Result};

/// The version of the layout above.
pub(crate) const VERSION: u32 = 1;

const SEAL: JsonSeal = JsonSeal { body: "items", version: VERSION, kind: "page of a list" };

/// A list that is only added to.
#[derive(Debug)]
pub struct Frozen<T> {
    store: Arc<dyn Store>,
    name: String,
    items: Vec<T>,
    /// The number of pages that the items came from.
    pages: usize,
}

/// The end of a list that was lost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The first page that cannot be read.
    pub page: String,
    /// What was found there, in words.
    pub why: String,
    /// The names under which that page and those after it are kept, if they were set aside.
    pub kept: Vec<String>,
}

impl<T: Serialize + DeserializeOwned> Frozen<T> {
    /// Reads a list up to the first page that cannot be read, and changes nothing.
    ///
    /// # Errors
    /// A page is of another version; the store fails.
    pub fn read(store: Arc<dyn Store>, name: &str) -> Result<(Frozen<T>, Option<Damage>)> {
        let mut frozen = Frozen { store, name: name.to_owned(), items: Vec::new(), pages: 0 };
        let there = frozen.there()?;
        let last = there.last().copied();
        while last.is_some_and(|last| frozen.pages <= last) {
            let page = frozen.page(frozen.pages);
            let found = if there.contains(&frozen.pages) {
                frozen.load(&page)?
            } else {
                Err("it is not there, but a later page is".to_owned())
            };
            match found {
                Ok(items) => frozen.push(items),
                Err(why) => return Ok((frozen, Some(Damage { page, why, kept: Vec::new() }))),
            }
        }
        Ok((frozen, None))
    }

    /// Reads a list for the holder of the run's lock, and sets aside the first page that cannot be read and all pages
    /// after it.
    ///
    /// # Errors
    /// As for [`Frozen::read`].
    pub fn open(store: Arc<dyn Store>, name: &str) -> Result<(Frozen<T>, Option<Damage>)> {
        let (frozen, mut damage) = Frozen::read(store, name)?;
        if let Some(damage) = &mut damage {
            // IMPORTANT: the last page goes first. Whenever this stops, the next try finds the same damage.
            for number in frozen.there()?.range(frozen.pages..).rev() {
                let page = frozen.page(*number);
                damage.kept.insert(0, corrupt::set_aside_as(&*frozen.store, &page, &page.replace('/', "-"))?);
            }
            frozen.store.sync(name)?;
        }
        Ok((frozen, damage))
    }

    /// The items, in the order in which they were added.
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Adds items as one page, unless another process added a page first: then the list goes on with that page, and the
    /// caller looks again at what is still missing.
    ///
    /// # Errors
    /// The other process's page is corrupt; the store fails.
    pub fn add(&mut self, more: Vec<T>) -> Result<Committed> {
        if more.is_empty() {
            return Ok(Committed::Now);
        }
        let page = self.page(self.pages);
        let text = SEAL.seal(&more).map_err(|why| Error::io("write", self.store.path(&page))(why.into()))?;
        let mut draft = self.store.create(&page)?;
        draft.write_all(&text).map_err(Error::io("write", draft.path()))?;
        let (_, committed) = draft.commit_first()?;
        let added = match committed {
            Committed::Now => more,
            Committed::Already => self.load(&page)?.map_err(|found| Error::malformed(self.store.path(&page), found))?,
        };
        self.push(added);
        Ok(committed)
    }

    /// The page that comes after those of the list.
    pub(crate) fn next_page(&self) -> String {
        self.page(self.pages)
    }

    fn push(&mut self, items: Vec<T>) {
        self.items.extend(items);
        self.pages += 1;
    }

    fn page(&self, number: usize) -> String {
        format!("{}/{number:06}.json", self.name)
    }

    /// The numbers of the pages that are there, or that an obstacle has the name of. Other files in the folder are left
    /// alone.
    fn there(&self) -> Result<BTreeSet<usize>> {
        let number = |name: &String| {
            let number = name.strip_prefix(&self.name)?.strip_prefix('/')?.strip_suffix(".json")?.parse().ok()?;
            (self.page(number) == *name).then_some(number)
        };
        let (files, obstacles) = (self.store.list(&self.name)?, self.store.obstacles(&self.name)?);
        Ok(files.iter().chain(&obstacles).filter_map(number).collect())
    }

    /// The items of a page, or what is wrong with it.
    fn load(&self, page: &str) -> Result<Result<Vec<T>, String>> {
        if self.store.is_obstructed(page)? {
            return Ok(Err(corrupt::OBSTACLE.to_owned()));
        }
        match SEAL.open(&self.store.read(page)?) {
            Ok(items) => Ok(Ok(items)),
            Err(Unreadable::Corrupt(why)) => Ok(Err(why)),
            Err(Unreadable::OtherVersion(why)) => {
                Err(Error::invalid(format!("{}: {why}", self.store.path(page).display())))
            }
        }
    }
}
