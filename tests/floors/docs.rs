//! Doc comments that leave out the noun they are about: "Which one.", "All of it.", "Makes it.".

/// Words that stand for a noun or go with one, but are none.
const EMPTY: &[&str] = &[
    "a",
    "about",
    "after",
    "all",
    "also",
    "an",
    "and",
    "any",
    "anything",
    "are",
    "as",
    "at",
    "be",
    "before",
    "both",
    "but",
    "by",
    "can",
    "did",
    "do",
    "does",
    "done",
    "each",
    "else",
    "everything",
    "few",
    "for",
    "from",
    "had",
    "has",
    "have",
    "here",
    "how",
    "if",
    "in",
    "is",
    "it",
    "its",
    "itself",
    "less",
    "like",
    "made",
    "many",
    "may",
    "more",
    "most",
    "much",
    "must",
    "next",
    "no",
    "none",
    "not",
    "nothing",
    "of",
    "on",
    "one",
    "ones",
    "only",
    "or",
    "other",
    "others",
    "own",
    "same",
    "so",
    "some",
    "something",
    "such",
    "than",
    "that",
    "the",
    "their",
    "them",
    "themselves",
    "then",
    "there",
    "these",
    "they",
    "this",
    "those",
    "to",
    "too",
    "two",
    "was",
    "well",
    "were",
    "what",
    "when",
    "where",
    "whether",
    "which",
    "who",
    "whole",
    "why",
    "will",
    "with",
    "without",
    "would",
];

/// Words that a doc comment must not begin with: their noun would stand elsewhere.
const ELSEWHERE: &[&str] = &["of", "it", "its", "itself", "they", "them", "their", "those"];

/// Whether a sentence leaves out its noun.
pub fn lacks_noun(sentence: &str) -> bool {
    // Code names something.
    if sentence.contains(['`', '[']) && !begins_elsewhere(sentence) {
        return false;
    }
    let words = words(sentence);
    let empty = |words: &[String]| words.iter().all(|word| EMPTY.contains(&word.as_str()));
    let pronoun =
        |word: &String| ["it", "them", "this", "that", "all", "both", "these", "those"].contains(&word.as_str());
    let acts_on_pronoun = words.len() > 1 && words[0].ends_with('s') && pronoun(&words[1]) && empty(&words[1..]);
    !words.is_empty() && (empty(&words) || acts_on_pronoun || begins_elsewhere(sentence))
}

fn begins_elsewhere(sentence: &str) -> bool {
    words(sentence).first().is_some_and(|first| ELSEWHERE.contains(&first.as_str()))
}

fn words(sentence: &str) -> Vec<String> {
    let words = sentence.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect()
}

/// The first sentence of each `///` comment, with the line that it begins on.
pub fn first_sentences(text: &str) -> Vec<(usize, String)> {
    let doc = |line: &str| line.trim_start().strip_prefix("///").map(|doc| doc.trim().to_owned());
    let lines: Vec<Option<String>> = text.lines().map(doc).collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        if line.is_none() || at.checked_sub(1).is_some_and(|before| lines[before].is_some()) {
            continue;
        }
        let comment = lines[at..].iter().map_while(Option::as_deref).take_while(|line| !line.is_empty());
        let comment = comment.collect::<Vec<_>>().join(" ");
        let sentence = comment.split_once(". ").map_or(comment.as_str(), |(first, _)| first).to_owned();
        found.push((at + 1, sentence));
    }
    found
}

#[test]
fn comments_without_a_noun_are_seen() {
    for sentence in [
        "Which one.",
        "All of it.",
        "The same.",
        "Makes it.",
        "How.",
        "How many.",
        "Both.",
        "Of which pipeline.",
        "Renders them all.",
        "Its name, as in the poses",
        "What is there.",
        "None.",
    ] {
        assert!(lacks_noun(sentence), "{sentence}");
    }
    for sentence in [
        "The shard's number.",
        "Builds the index.",
        "Triangles in all.",
        "Makes it a city.",
        "Photographs.",
        "`None` if nothing is.",
        "Whether the folder holds the city.",
        "What a run takes.",
        "One material for each.",
        "",
    ] {
        assert!(!lacks_noun(sentence), "{sentence}");
    }
    let text = "/// The mesh\n/// of all. More.\nstruct A;\n\n    /// Both.\n    /// \n    /// And more.\nfn f() {}";
    assert_eq!(first_sentences(text), [(1, "The mesh of all".into()), (5, "Both.".into())]);
}
