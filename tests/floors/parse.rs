//! What a source file defines, and every path that it names.

use std::collections::BTreeSet;

use crate::tokens::{Token, group_end, is_name, tested, tokens, word};

/// The names from the root of the crate to a module.
pub type ModulePath = Vec<String>;

/// What one module, a file or a `mod x { .. }` within one, consists of.
#[derive(Debug, Default)]
pub struct Module {
    pub path: ModulePath,
    /// Items that the module itself defines.
    pub defines: BTreeSet<String>,
    /// Child modules, in files of their own or within this one.
    pub children: BTreeSet<String>,
    /// Child modules that are there for tests only.
    pub test_children: BTreeSet<String>,
    /// Imports, by `use`.
    pub uses: Vec<Use>,
}

/// One name that a `use` brings in.
#[derive(Debug, Clone)]
pub struct Use {
    pub path: Vec<String>,
    /// The name in this module; `None` for a glob.
    pub alias: Option<String>,
}

/// A place where a file names something.
#[derive(Debug)]
pub struct Reference {
    pub line: usize,
    /// The module that the reference stands in.
    pub module: ModulePath,
    pub path: Vec<String>,
    pub form: Form,
    /// Whether the reference stands in code for tests.
    pub test: bool,
}

/// How something is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// By a private `use`.
    Use,
    /// By a `use` of everything in a module.
    Glob,
    /// By a `pub use`.
    Reexport,
    /// By a path of two names or more in an expression or a type.
    Path,
    /// By a single name that could be an item's.
    Word,
}

/// A parsed file: its own module first.
#[derive(Debug)]
pub struct Parsed {
    pub modules: Vec<Module>,
    pub references: Vec<Reference>,
}

/// Parses the file of a module.
pub fn parse(path: &[String], text: &str) -> Parsed {
    let tokens = tokens(text);
    let mut parser = Parser {
        tested: tested(&tokens),
        tokens: &tokens,
        open: vec![(0, 0)],
        modules: vec![Module { path: path.to_vec(), ..Module::default() }],
        references: Vec::new(),
    };
    let (mut at, mut depth) = (0, 0);
    while at < tokens.len() {
        match word(&tokens, at) {
            "{" => depth += 1,
            "}" => {
                depth = usize::saturating_sub(depth, 1);
                parser.open.retain(|(_, opened)| *opened <= depth);
            }
            _ => {}
        }
        at = parser.step(at, depth);
    }
    Parsed { modules: parser.modules, references: parser.references }
}

struct Parser<'t> {
    tokens: &'t [Token],
    tested: Vec<bool>,
    /// The modules that are open, each with the depth of braces inside it.
    open: Vec<(usize, usize)>,
    modules: Vec<Module>,
    references: Vec<Reference>,
}

impl Parser<'_> {
    fn word(&self, at: usize) -> &str {
        word(self.tokens, at)
    }

    fn here(&self) -> (usize, usize) {
        self.open.last().copied().unwrap_or_default()
    }

    fn module(&mut self) -> &mut Module {
        let (module, _) = self.here();
        &mut self.modules[module]
    }

    /// Reads what begins at a token, and gives the position after it.
    fn step(&mut self, at: usize, depth: usize) -> usize {
        if !is_name(self.tokens, at) {
            return at + 1;
        }
        let before = at.checked_sub(1).map_or("", |before| self.word(before)).to_owned();
        let next = self.word(at + 1).to_owned();
        match self.word(at) {
            "mod" if is_name(self.tokens, at + 1) => return self.mod_item(at, depth),
            "use" if before != "." && next != "<" => return self.use_item(at, &before),
            keyword if depth == self.here().1 => {
                if let Some(name) = defined(self.tokens, at, keyword) {
                    if !self.tested[at] {
                        self.module().defines.insert(name);
                    }
                    return at + 1;
                }
            }
            _ => {}
        }
        if next == "::" && before != "::" {
            return self.path(at);
        }
        let name = self.word(at).to_owned();
        let apart = ["::", ".", "fn", "'"].contains(&before.as_str());
        if !apart && (name.starts_with(char::is_uppercase) || next == "(" || next == "!") {
            self.refer(at, vec![name], Form::Word);
        }
        at + 1
    }

    fn refer(&mut self, at: usize, path: Vec<String>, form: Form) {
        let module = self.module().path.clone();
        let (line, test) = (self.tokens[at].0, self.tested[at]);
        self.references.push(Reference { line, module, path, form, test });
    }

    fn mod_item(&mut self, at: usize, depth: usize) -> usize {
        let (name, test) = (self.word(at + 1).to_owned(), self.tested[at]);
        let parent = self.module();
        parent.children.insert(name.clone());
        if test {
            parent.test_children.insert(name.clone());
        }
        let path = [&parent.path[..], &[name]].concat();
        if self.word(at + 2) == "{" {
            self.modules.push(Module { path, ..Module::default() });
            self.open.push((self.modules.len() - 1, depth + 1));
        }
        at + 2
    }

    fn use_item(&mut self, at: usize, before: &str) -> usize {
        let public = before == "pub" || (before == ")" && self.is_visibility(at - 1));
        let mut leaves = Vec::new();
        let end = tree(self.tokens, at + 1, &[], &mut leaves);
        for leaf in leaves {
            let form = match (public, &leaf.alias) {
                (true, _) => Form::Reexport,
                (false, None) => Form::Glob,
                (false, Some(_)) => Form::Use,
            };
            self.refer(at, leaf.path.clone(), form);
            if !self.tested[at] {
                self.module().uses.push(leaf);
            }
        }
        end + 1
    }

    /// Whether the bracket that closes at a position is that of `pub(..)`.
    fn is_visibility(&self, close: usize) -> bool {
        let open = (0..close).rev().find(|&i| self.word(i) == "(");
        open.is_some_and(|open| open > 0 && self.word(open - 1) == "pub" && group_end(self.tokens, open) == close + 1)
    }

    /// A path in an expression or a type.
    fn path(&mut self, at: usize) -> usize {
        let mut path = vec![self.word(at).to_owned()];
        let mut last = at;
        while self.word(last + 1) == "::" && is_name(self.tokens, last + 2) {
            last += 2;
            path.push(self.word(last).to_owned());
        }
        self.refer(at, path, Form::Path);
        last + 1
    }
}

/// The name that an item's keyword defines.
fn defined(tokens: &[Token], at: usize, keyword: &str) -> Option<String> {
    let name = match keyword {
        "struct" | "enum" | "trait" | "type" | "fn" => at + 1,
        "static" if word(tokens, at + 1) == "mut" => at + 2,
        "static" => at + 1,
        "const" if !["fn", "unsafe", "async", "extern", "_"].contains(&word(tokens, at + 1)) => at + 1,
        "union" if is_name(tokens, at + 1) && ["{", "<"].contains(&word(tokens, at + 2)) => at + 1,
        "macro_rules" if word(tokens, at + 1) == "!" => at + 2,
        _ => return None,
    };
    is_name(tokens, name).then(|| word(tokens, name).to_owned())
}

/// Reads one tree of a `use` and gives the position after it.
fn tree(tokens: &[Token], mut at: usize, prefix: &[String], leaves: &mut Vec<Use>) -> usize {
    let mut path = prefix.to_vec();
    loop {
        match word(tokens, at) {
            "{" => {
                at += 1;
                while !["}", ""].contains(&word(tokens, at)) {
                    at = tree(tokens, at, &path, leaves);
                    at += usize::from(word(tokens, at) == ",");
                }
                return at + 1;
            }
            "*" => {
                leaves.push(Use { path, alias: None });
                return at + 1;
            }
            "$" => at += 1,
            // `::name` is another crate.
            "::" if path.is_empty() => path.push(String::new()),
            "::" => at += 1,
            "" | ";" | "}" | "," => return at,
            name => {
                if name != "self" || path.is_empty() {
                    path.push(name.to_owned());
                }
                at += 1;
                if word(tokens, at) == "::" {
                    continue;
                }
                let renamed = word(tokens, at) == "as";
                let alias = if renamed { word(tokens, at + 1) } else { path.last().map_or("", String::as_str) };
                leaves.push(Use { alias: Some(alias.to_owned()), path });
                return at + if renamed { 2 } else { 0 };
            }
        }
    }
}
