//! All files of a crate: where a path leads, and which file imports what of which other.

use std::collections::{BTreeMap, BTreeSet};

use crate::parse::{Form, Module, ModulePath, Reference, parse};

/// A source file.
#[derive(Debug, Clone)]
pub struct Source {
    /// The path from `src`, with slashes.
    pub name: String,
    pub text: String,
}

impl Source {
    /// The module of the file: `["scene", "mesh"]` for `scene/mesh.rs`.
    pub fn module(&self) -> ModulePath {
        let mut module: Vec<String> = self.name.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
            module.pop();
        }
        module
    }

    /// Whether the file is where a folder, or the crate, shows what its files define.
    fn is_face(&self) -> bool {
        self.name == "lib.rs" || self.name.ends_with("mod.rs")
    }
}

/// Where a path leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    Module(ModulePath),
    /// An item, with the file that defines it.
    Item(usize, String),
}

/// For each file the files that it imports from, with the names of the items.
pub type Edges = BTreeMap<usize, BTreeMap<usize, BTreeSet<String>>>;

/// The parsed files of a crate.
pub struct Crate {
    pub sources: Vec<Source>,
    modules: BTreeMap<ModulePath, (usize, Module)>,
    /// What each file names.
    pub references: Vec<Vec<Reference>>,
    /// Modules that are there for tests only, with all below them.
    tests: BTreeSet<ModulePath>,
}

impl Crate {
    pub fn new(sources: Vec<Source>) -> Crate {
        let (mut modules, mut references, mut tests) = (BTreeMap::new(), Vec::new(), BTreeSet::new());
        for (file, source) in sources.iter().enumerate() {
            let parsed = parse(&source.module(), &source.text);
            for module in parsed.modules {
                tests.extend(
                    module.test_children.iter().map(|name| [&module.path[..], std::slice::from_ref(name)].concat()),
                );
                // `main.rs` is a crate of its own.
                if source.name != "main.rs" {
                    modules.insert(module.path.clone(), (file, module));
                }
            }
            references.push(parsed.references);
        }
        Crate { sources, modules, references, tests }
    }

    /// Whether a module is there for tests only.
    pub fn is_test(&self, module: &[String]) -> bool {
        (1..=module.len()).any(|n| self.tests.contains(&module[..n]))
    }

    /// The path from the root of the crate, where it is written as one: `crate::..` or `super::..`.
    pub fn absolute(reference: &Reference) -> Option<Vec<String>> {
        let supers = reference.path.iter().take_while(|name| *name == "super").count();
        match reference.path.first()?.as_str() {
            "crate" => Some(reference.path[1..].to_vec()),
            "super" => {
                let above = reference.module.len().checked_sub(supers);
                let above = above.unwrap_or_else(|| panic!("more supers than modules in {reference:?}"));
                Some([&reference.module[..above], &reference.path[supers..]].concat())
            }
            _ => None,
        }
    }

    /// Where a path that is written in a module leads, if into this crate.
    pub fn resolve(&self, module: &[String], path: &[String]) -> Option<Target> {
        self.follow(module, path, &mut BTreeSet::new())
    }

    fn follow(
        &self,
        module: &[String],
        path: &[String],
        seen: &mut BTreeSet<(ModulePath, Vec<String>)>,
    ) -> Option<Target> {
        if !seen.insert((module.to_vec(), path.to_vec())) {
            return None;
        }
        let (first, mut rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => Vec::new(),
            "self" => module.to_vec(),
            "super" => module[..module.len().checked_sub(1)?].to_vec(),
            _ => {
                rest = path;
                module.to_vec()
            }
        };
        while let Some((name, after)) = rest.split_first() {
            rest = after;
            if name == "super" {
                at.pop()?;
                continue;
            }
            match self.look_up(&at, name, rest.is_empty(), seen)? {
                Target::Module(inner) => at = inner,
                item => return Some(item),
            }
        }
        Some(Target::Module(at))
    }

    /// What a name is in a module. A module and an item may share a name: the last name of a path is the item, the others
    /// are modules.
    fn look_up(
        &self,
        module: &[String],
        name: &String,
        last: bool,
        seen: &mut BTreeSet<(ModulePath, Vec<String>)>,
    ) -> Option<Target> {
        let (file, found) = self.modules.get(module)?;
        let child =
            found.children.contains(name).then(|| Target::Module([module, std::slice::from_ref(name)].concat()));
        if child.is_some() && !last {
            return child;
        }
        if found.defines.contains(name) {
            return Some(Target::Item(*file, name.clone()));
        }
        let named = found.uses.iter().filter(|u| u.alias.as_ref() == Some(name));
        let imported: Vec<Target> = named.filter_map(|u| self.follow(module, &u.path, seen)).collect();
        let fitting = |target: &&Target| matches!(target, Target::Item(..)) == last;
        if let Some(imported) = imported.iter().find(fitting).or(imported.first()) {
            return Some(imported.clone());
        }
        if child.is_some() {
            return child;
        }
        found.uses.iter().filter(|u| u.alias.is_none()).find_map(|glob| {
            match self.follow(module, &glob.path, seen)? {
                Target::Module(inner) if inner != module => self.look_up(&inner, name, last, seen),
                _ => None,
            }
        })
    }

    /// The item that a reference imports, with the file that defines it. The face of a folder imports what it only shows as
    /// little as what it declares.
    fn import(&self, file: usize, reference: &Reference) -> Option<(usize, String)> {
        let (_, module) = self.modules.get(&reference.module)?;
        let is_face = self.sources[file].is_face();
        let name = &reference.path[0];
        let shown = |alias: &Option<String>| alias.as_ref().is_none_or(|alias| alias == name);
        let wanted = match reference.form {
            Form::Use | Form::Path => true,
            Form::Reexport => !is_face,
            Form::Glob => false,
            // A single name means an import only where no `use` that counts has brought it in.
            Form::Word if is_face => module.uses.iter().any(|u| shown(&u.alias)),
            Form::Word => module.uses.iter().any(|u| u.alias.is_none()),
        };
        match self.resolve(&reference.module, &reference.path).filter(|_| wanted)? {
            Target::Item(to, name) if to != file => Some((to, name)),
            _ => None,
        }
    }

    /// What the files import of each other, tests left out.
    pub fn edges(&self) -> Edges {
        let mut edges = Edges::new();
        for (file, references) in self.references.iter().enumerate() {
            for reference in references.iter().filter(|r| !r.test && !self.is_test(&r.module)) {
                if let Some((to, name)) = self.import(file, reference) {
                    edges.entry(file).or_default().entry(to).or_default().insert(name);
                }
            }
        }
        edges
    }

    /// Lines of `a.rs -> b.rs: Names`.
    pub fn lines(&self, edges: &Edges) -> Vec<String> {
        let line = |from: usize, to: usize, names: &BTreeSet<String>| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("{} -> {}: {}", self.sources[from].name, self.sources[to].name, names.join(", "))
        };
        edges.iter().flat_map(|(from, all)| all.iter().map(move |(to, names)| line(*from, *to, names))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The imports of a crate of these files.
    fn edges(files: &[(&str, &str)]) -> Vec<String> {
        let source = |(name, text): &(&str, &str)| Source { name: (*name).into(), text: (*text).into() };
        let all = Crate::new(files.iter().map(source).collect());
        all.lines(&all.edges())
    }

    const LIB: (&str, &str) = ("lib.rs", "pub mod base; pub mod scene;");
    const BASE: (&str, &str) =
        ("base.rs", "pub struct Error; pub fn trim() {} pub enum Side { Left } pub mod ids { pub struct Id; }");

    fn one(name: &str, text: &str) -> Vec<String> {
        edges(&[
            LIB,
            BASE,
            ("scene/mod.rs", "mod mesh; mod view; pub use view::View;"),
            ("scene/view.rs", "pub struct View;"),
            (name, text),
        ])
    }

    #[test]
    fn paths_lead_to_the_file_that_defines_the_item() {
        for (text, names) in [
            ("use crate::base::Error;", "base.rs: Error"),
            ("use crate::{base::{self, Error as E, ids::Id}};", "base.rs: Error, Id"),
            ("use crate::base; fn f() { base::trim() }", "base.rs: trim"),
            ("fn f() -> crate::base::Side { super::super::base::Side::Left }", "base.rs: Side"),
            ("use crate::base::*; fn f() { trim(); } struct Bin;", "base.rs: trim"),
            ("use crate::base::Side::Left;", "base.rs: Side"),
            ("mod inner { use super::super::super::base::Error; }", "base.rs: Error"),
            ("pub use super::View;", "scene/view.rs: View"),
            ("use super::view; fn f(_: &view::View) {}", "scene/view.rs: View"),
            ("use crate::scene as s; type V = Vec<s::View>;", "scene/view.rs: View"),
        ] {
            assert_eq!(one("scene/mesh.rs", text), [format!("scene/mesh.rs -> {names}")], "{text}");
        }
    }

    #[test]
    fn declarations_tests_and_other_crates_are_no_imports() {
        for text in [
            "use crate::base;",
            "use std::io::Error; fn f() { io::Error::new() }",
            "use ::base::Error;",
            "// crate::base::Error\nconst S: &str = \"crate::base::Error\";",
            "#[cfg(test)] mod tests { use crate::base::Error; }",
            "#[cfg(test)] use crate::base::Error;",
            "#[test] fn f() { crate::base::trim() }",
            "struct S { #[cfg(test)] e: crate::base::Error, n: u32 }",
            "struct Error; fn f() -> Error { self::Error }",
        ] {
            assert_eq!(one("scene/mesh.rs", text), Vec::<String>::new(), "{text}");
        }
        let after = "#[cfg(test)] use a::{b}; #[cfg(test)] fn f() { x } fn g() { crate::base::trim() }";
        assert_eq!(one("scene/mesh.rs", after), ["scene/mesh.rs -> base.rs: trim"]);
        let files =
            [LIB, BASE, ("scene/mod.rs", "#[cfg(test)] mod tests;"), ("scene/tests.rs", "use crate::base::Error;")];
        assert_eq!(edges(&files), Vec::<String>::new());
    }

    #[test]
    fn a_face_imports_what_it_uses_and_not_what_it_shows() {
        let mesh = ("scene/mesh.rs", "pub struct Mesh; pub fn load() {} pub mod read { pub fn load() {} }");
        for (text, found) in [
            ("pub mod mesh; pub use mesh::{Mesh, load};", None),
            ("pub mod mesh; pub(crate) use mesh::Mesh;", None),
            ("mod mesh; use mesh::Mesh;", Some("Mesh")),
            ("mod mesh; pub use mesh::Mesh; fn f(_: &Mesh) {}", Some("Mesh")),
            ("mod mesh; pub use mesh::load; pub fn f() { load() }", Some("load")),
            ("mod mesh; pub use mesh::load; pub fn f(store: S) { store.load() }", None),
            ("mod mesh; pub fn f() { mesh::read::load() }", Some("load")),
        ] {
            let found: Vec<String> =
                found.iter().map(|name| format!("scene/mod.rs -> scene/mesh.rs: {name}")).collect();
            assert_eq!(edges(&[LIB, BASE, ("scene/mod.rs", text), mesh]), found, "{text}");
        }
    }

    #[test]
    fn a_module_and_an_item_may_share_a_name() {
        let files = |text| {
            let scene = ("scene/mod.rs", "pub mod relight; pub use relight::relight;");
            edges(&[
                ("lib.rs", "mod scene; mod cli;"),
                scene,
                ("scene/relight.rs", "pub fn relight() {} pub struct Rendering;"),
                ("cli.rs", text),
            ])
        };
        assert_eq!(files("use crate::scene::relight;"), ["cli.rs -> scene/relight.rs: relight"]);
        assert_eq!(files("use crate::scene::relight::Rendering;"), ["cli.rs -> scene/relight.rs: Rendering"]);
        let both = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "pub fn export() {}"),
            ("b/mod.rs", "pub mod export;"),
            ("b/export.rs", "pub struct Config;"),
            ("c.rs", "pub use crate::a::export; use crate::b::export; struct C(export::Config);"),
        ];
        assert_eq!(edges(&both), ["c.rs -> a.rs: export", "c.rs -> b/export.rs: Config"]);
    }
}
