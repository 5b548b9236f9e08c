//! Frozen lists: what was added stays in its order, and a corrupt page costs the end of the list alone.

use std::sync::Arc;

use super::{mangle, on_each_store};
use crate::disk::frozen::Frozen;
use crate::disk::{Committed, Damage, MemStore, Store};

type List = Frozen<Vec<String>>;

fn item(number: u32) -> Vec<String> {
    vec![number.to_string(), "b \"quoted\"".to_owned()]
}

fn read(store: &Arc<dyn Store>) -> (List, Option<Damage>) {
    List::read(Arc::clone(store), "groups").unwrap()
}

fn open(store: &Arc<dyn Store>) -> (List, Option<Damage>) {
    List::open(Arc::clone(store), "groups").unwrap()
}

/// A list of three pages, with the items 0 to 3.
fn three_pages(store: &Arc<dyn Store>) -> List {
    let (mut list, damage) = open(store);
    assert!(list.items().is_empty() && damage.is_none());
    for page in [vec![item(0), item(1)], vec![item(2)], vec![item(3)]] {
        assert_eq!(list.add(page).unwrap(), Committed::Now);
    }
    list
}

fn items(numbers: impl IntoIterator<Item = u32>) -> Vec<Vec<String>> {
    numbers.into_iter().map(item).collect()
}

#[test]
fn what_is_added_stays_in_its_order() {
    on_each_store(|store| {
        let mut written = three_pages(&store);
        assert_eq!(written.add(vec![]).unwrap(), Committed::Now);
        let pages = ["groups/000000.json", "groups/000001.json", "groups/000002.json"];
        assert_eq!(store.list("").unwrap(), pages, "nothing is no page");
        for (list, damage) in [(written, None), read(&store), open(&store)] {
            assert_eq!((list.items(), damage), (&items(0..4)[..], None));
        }
    });
}

#[test]
fn the_slower_one_goes_on_with_the_other_ones_page() {
    on_each_store(|store| {
        let mut faster = three_pages(&store);
        let mut slower = read(&store).0;
        assert_eq!(faster.add(items([4, 5])).unwrap(), Committed::Now);
        assert_eq!(faster.add(items([6])).unwrap(), Committed::Now);
        assert_eq!(slower.add(items([5, 7])).unwrap(), Committed::Already);
        assert_eq!(slower.items(), items(0..6));
        assert_eq!(slower.add(items([7])).unwrap(), Committed::Already);
        assert_eq!(slower.add(items([7])).unwrap(), Committed::Now);
        assert_eq!((slower.items(), read(&store).0.items()), (&items(0..8)[..], &items(0..8)[..]));
    });
}

#[test]
fn every_truncation_and_every_flipped_bit_costs_that_page_and_those_after_it() {
    // In memory alone: thousands of files, each synced, take a disk minutes.
    let store: Arc<dyn Store> = Arc::new(MemStore::new());
    three_pages(&store);
    let whole = store.open("groups/000001.json").unwrap().to_vec();
    let check = |bytes: &[u8], what: String| {
        mangle(&*store, "groups/000001.json", bytes);
        let (list, damage) = read(&store);
        assert_eq!(list.items(), items(0..2), "{what}");
        assert_eq!(damage.unwrap().page, "groups/000001.json", "{what}");
    };
    (0..whole.len()).for_each(|cut| check(&whole[..cut], format!("cut to {cut}")));
    for bit in 0..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        check(&flipped, format!("bit {bit}"));
    }
}

#[test]
fn a_corrupt_page_is_set_aside_with_those_after_it() {
    on_each_store(|store| {
        three_pages(&store);
        mangle(&*store, "groups/000001.json", b"{");
        let before = store.list("").unwrap();
        let (mut list, damage) = read(&store);
        let Some(Damage { page, why, kept }) = damage else { panic!("no damage") };
        assert!(page == "groups/000001.json" && why.contains("page of a list") && kept.is_empty(), "{why}");
        assert_eq!(store.list("").unwrap(), before, "reading changes nothing");
        let why = list.add(items([9])).unwrap_err();
        assert_eq!(why.malformed_file(), Some(&*store.path("groups/000001.json")));

        let (mut list, damage) = open(&store);
        let kept = ["corrupt/groups-000001.json", "corrupt/groups-000002.json"];
        assert_eq!((list.items(), damage.unwrap().kept), (&items(0..2)[..], kept.map(str::to_owned).to_vec()));
        assert_eq!(store.list("").unwrap(), [kept[0], kept[1], "groups/000000.json"]);
        assert_eq!(&*store.open(kept[0]).unwrap(), b"{");
        assert_eq!(open(&store).1, None, "it is reported once");
        assert_eq!(list.add(items([2, 3])).unwrap(), Committed::Now);
        assert_eq!(open(&store).0.items(), items(0..4));
    });
}

#[test]
fn a_page_that_is_gone_ends_the_list() {
    on_each_store(|store| {
        three_pages(&store);
        store.remove("groups/000000.json").unwrap();
        let (list, damage) = open(&store);
        let Some(Damage { page, why, kept }) = damage else { panic!("no damage") };
        assert_eq!((page.as_str(), why.as_str()), ("groups/000000.json", "it is not there, but a later page is"));
        assert_eq!((list.items().len(), kept.len()), (0, 2));
        assert!(store.list("groups").unwrap().is_empty());
    });
}

#[test]
fn another_version_is_refused_and_nothing_changes() {
    on_each_store(|store| {
        three_pages(&store);
        mangle(&*store, "groups/000001.json", br#"{"version":2,"anything":"else"}"#);
        let before = store.list("").unwrap();
        for refused in [List::open, List::read] {
            let why = refused(Arc::clone(&store), "groups").unwrap_err().to_string();
            assert!(
                why.contains("000001.json: a page of a list of version 2; this gonio reads version 1: use"),
                "{why}"
            );
        }
        assert_eq!(store.list("").unwrap(), before);
    });
}

#[test]
fn other_files_among_the_pages_are_left_alone() {
    on_each_store(|store| {
        three_pages(&store);
        let strange = ["groups/README", "groups/7.json", "groups/+00007.json", "groups/deep/000007.json"];
        strange.iter().for_each(|name| mangle(&*store, name, b"strange"));
        let (list, damage) = open(&store);
        assert_eq!((list.items().len(), damage), (4, None));
    });
}
