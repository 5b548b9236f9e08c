//! Files that import each other in a circle.

use std::collections::BTreeSet;

use crate::resolve::{Crate, Edges};

/// The imports within each circle, a line for each: `a.rs -> b.rs: Names`.
pub fn circles(all: &Crate) -> Vec<Vec<String>> {
    let edges = all.edges();
    let reached: Vec<BTreeSet<usize>> = (0..all.sources.len()).map(|from| reach(&edges, from)).collect();
    let mut told = BTreeSet::new();
    let mut circles = Vec::new();
    for start in 0..reached.len() {
        if told.contains(&start) || !reached[start].contains(&start) {
            continue;
        }
        let circle: BTreeSet<usize> =
            reached[start].iter().copied().filter(|to| reached[*to].contains(&start)).collect();
        let mut within = edges.clone();
        within.retain(|from, to| {
            to.retain(|to, _| circle.contains(to));
            circle.contains(from)
        });
        circles.push(all.lines(&within));
        told.extend(circle);
    }
    circles
}

/// All files that one leads to.
fn reach(edges: &Edges, from: usize) -> BTreeSet<usize> {
    let (mut reached, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(at) = next.pop() {
        next.extend(edges.get(&at).into_iter().flat_map(|to| to.keys()).filter(|to| reached.insert(**to)));
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::Source;

    fn found(files: &[(&str, &str)]) -> Vec<Vec<String>> {
        let source = |(name, text): &(&str, &str)| Source { name: (*name).into(), text: (*text).into() };
        circles(&Crate::new(files.iter().map(source).collect()))
    }

    #[test]
    fn circles_are_told_with_the_names_that_close_them() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c; mod d; mod e;"),
            ("a.rs", "pub struct A; use crate::b::B;"),
            ("b.rs", "pub struct B; use crate::c::{C, D};"),
            ("c.rs", "pub struct C; pub struct D; fn f(_: super::a::A, _: super::e::E) {}"),
            ("d.rs", "use crate::a::A;"),
            ("e.rs", "pub struct E;"),
        ];
        assert_eq!(found(&files), [["a.rs -> b.rs: B", "b.rs -> c.rs: C, D", "c.rs -> a.rs: A"]]);
        let open = ("c.rs", "pub struct C; pub struct D; #[cfg(test)] mod tests { use crate::a::A; }");
        assert!(found(&[files[0], files[1], files[2], open, files[4]]).is_empty());
    }

    #[test]
    fn a_folder_closes_a_circle_only_if_its_face_uses_its_files() {
        let child = ("s/x.rs", "use super::Shared; pub struct X;");
        let face = |text| found(&[("lib.rs", "mod s;"), ("s/mod.rs", text), child]);
        assert!(face("mod x; pub use x::X; pub struct Shared;").is_empty());
        let closed = [["s/mod.rs -> s/x.rs: X", "s/x.rs -> s/mod.rs: Shared"]];
        assert_eq!(face("mod x; pub use x::X; pub struct Shared(Box<X>);"), closed);
        assert_eq!(face("mod x; use x::X; pub struct Shared;"), closed);
    }
}
