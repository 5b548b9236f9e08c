//! The template is what the sections say of their keys.

use std::path::Path;

use super::TEMPLATE;
use crate::pipeline::sections::SECTIONS;
use crate::pipeline::template;

#[test]
fn the_template_is_made_of_the_sections() {
    let made = template();
    if std::env::var_os("GONIO_WRITE_TEMPLATE").is_some() {
        std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/colmap.toml"), &made).unwrap();
        return;
    }
    let differs = made.lines().zip(TEMPLATE.lines()).find(|(made, there)| made != there);
    assert!(
        made == TEMPLATE,
        "pipelines/colmap.toml is not what the sections say, first at {differs:?}; this writes it again: \
         GONIO_WRITE_TEMPLATE=1 cargo test --lib the_template_is_made"
    );
}

#[test]
fn every_key_is_explained_in_plain_sentences() {
    for section in &SECTIONS {
        assert!(section.about.ends_with('.'), "{}: {}", section.name, section.about);
        for key in section.keys {
            let doc = key.doc;
            assert!(
                doc.len() > 10 && !doc.contains('\n') && doc.ends_with('.'),
                "{}.{}: {doc}",
                section.name,
                key.name
            );
        }
    }
}
