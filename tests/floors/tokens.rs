//! A source file as tokens, and which of them belong to tests.

/// A word, `::` or another sign, with its line.
pub type Token = (usize, String);

/// The text of the token at a position; empty beyond the last.
pub fn word(tokens: &[Token], at: usize) -> &str {
    tokens.get(at).map_or("", |(_, token)| token)
}

/// Whether the token at a position is a name or a keyword.
pub fn is_name(tokens: &[Token], at: usize) -> bool {
    word(tokens, at).starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The position after the item that begins at `at`: after its `;` or its body.
fn item_end(tokens: &[Token], mut at: usize) -> usize {
    while word(tokens, at) == "#" {
        at = group_end(tokens, at + 1);
    }
    let head = (at..).find(|&i| !["pub", "unsafe", "async", "extern"].contains(&word(tokens, i))).unwrap_or(at);
    let head = if word(tokens, head) == "(" { group_end(tokens, head) } else { head };
    let keyword = word(tokens, head);
    let with_body = ["mod", "fn", "impl", "struct", "enum", "union", "trait", "macro_rules"].contains(&keyword)
        || (keyword == "const" && word(tokens, head + 1) == "fn");
    let is_item = with_body || ["use", "const", "static", "type", "let"].contains(&keyword);
    while at < tokens.len() {
        match word(tokens, at) {
            ";" => return at + 1,
            // A field, an argument, an arm or a variant.
            "," | "}" | ")" if !is_item => return at,
            "{" if with_body => return group_end(tokens, at),
            "{" | "(" | "[" => at = group_end(tokens, at),
            _ => at += 1,
        }
    }
    at
}

/// The position after the bracket that closes the one at `at`.
pub fn group_end(tokens: &[Token], at: usize) -> usize {
    let mut depth = 0;
    for i in at..tokens.len() {
        match word(tokens, i) {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}

/// For each token whether it stands in an item that is only there for tests: under `#[cfg(test)]` or `#[test]`.
pub fn tested(tokens: &[Token]) -> Vec<bool> {
    let mut tested = vec![false; tokens.len()];
    let is_attribute = |at: usize, words: &[&str]| {
        word(tokens, at) == "#"
            && word(tokens, at + 1) == "["
            && words.iter().enumerate().all(|(i, w)| word(tokens, at + 2 + i) == *w)
    };
    let marks = [&["cfg", "(", "test", ")"][..], &["cfg", "(", "all", "(", "test"], &["test", "]"]];
    for at in 0..tokens.len() {
        if !tested[at] && marks.iter().any(|mark| is_attribute(at, mark)) {
            let end = item_end(tokens, at);
            tested[at..end].fill(true);
        }
    }
    tested
}

/// Words, `::` and other signs, each with its line; comments and the insides of literals are left out.
pub fn tokens(text: &str) -> Vec<Token> {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let (mut tokens, mut i, mut line) = (Vec::new(), 0, 1);
    let wordy = |c: char| c.is_alphanumeric() || c == '_';
    while i < c.len() {
        let start = i;
        match c[i] {
            '/' if at(i + 1) == '/' => i = (i..c.len()).find(|&j| c[j] == '\n').unwrap_or(c.len()),
            '/' if at(i + 1) == '*' => {
                let end = (i + 2..c.len()).find(|&j| c[j] == '*' && at(j + 1) == '/');
                i = end.map_or(c.len(), |end| end + 2);
            }
            '"' => {
                i += 1;
                while i < c.len() && c[i] != '"' {
                    i += if c[i] == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            // A raw string, its hashes counted; `r#name` is a word.
            'r' if at(i + 1) == '"' || (at(i + 1) == '#' && (at(i + 2) == '#' || at(i + 2) == '"')) => {
                let hashes = (i + 1..c.len()).take_while(|&j| c[j] == '#').count();
                let closes = |j: usize| c[j] == '"' && (1..=hashes).all(|h| at(j + h) == '#');
                i = (i + hashes + 2..c.len()).find(|&j| closes(j)).map_or(c.len(), |end| end + hashes + 1);
            }
            // A character, not a lifetime.
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += if at(i + 1) == '\\' { 3 } else { 2 };
                while i < c.len() && c[i] != '\'' {
                    i += 1;
                }
                i += 1;
            }
            ch if wordy(ch) => {
                while wordy(at(i)) {
                    i += 1;
                }
                tokens.push((line, c[start..i].iter().collect()));
            }
            ':' if at(i + 1) == ':' => {
                tokens.push((line, "::".to_owned()));
                i += 2;
            }
            ch => {
                if !ch.is_whitespace() {
                    tokens.push((line, ch.to_string()));
                }
                i += 1;
            }
        }
        line += c[start..i.min(c.len())].iter().filter(|ch| **ch == '\n').count();
    }
    tokens
}
