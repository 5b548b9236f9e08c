//! Section `[export]`.

use super::exporter::Exporter;
use super::list::EXPORTERS;
use crate::config::{Effect, Former, Key, Keys, Now, Section, Settings, Value};

/// Section `[export]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The formats to write, each at most once; none is allowed.
    pub formats: Vec<Exporter>,
}

impl Section for Config {
    const NAME: &'static str = "export";
    const ABOUT: &'static str = "The files for other programs.";
    const KEYS: &'static [Key] = &[Key {
        name: "formats",
        doc: "The formats to write: \"ply\", faces with material and evidence; \"glb\", for Blender and web viewers. [] writes \
              none.",
        value: Value::Default("[\"ply\", \"glb\"]"),
    }];
    const FORMER: &'static [Former] = &[Former { name: "up", now: Now::Moved("[scene] up") }];

    fn read(keys: &Keys<'_>) -> Self {
        Config::read_among(keys, EXPORTERS)
    }

    fn settings(&self) -> Settings {
        let Config { formats } = self;
        let names: Vec<&str> = formats.iter().map(|format| format.name).collect();
        Settings::of(Self::NAME).with("formats", names, Effect::Formats)
    }
}

impl Config {
    /// Reads the section where these are all the formats.
    fn read_among(keys: &Keys<'_>, exporters: &[Exporter]) -> Self {
        let named: Vec<(&'static str, Exporter)> =
            exporters.iter().map(|exporter| (exporter.name, *exporter)).collect();
        Config { formats: keys.choices("formats", &named) }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::base::Error;
    use crate::base::ids::TriangleId;
    use crate::config::{Document, Faults, raw, read_text};
    use crate::disk::{MemStore, Store};
    use crate::scene::Mesh;
    use crate::scene::evidence::Evidence;
    use crate::stages::export::Surface;
    use crate::stages::merge::Materials;

    #[test]
    fn formats_are_named_once() {
        for (text, problems) in
            [("", 0), ("formats = []", 0), ("formats = ['glb']", 0), ("formats = ['glb', 'glb']", 1)]
        {
            assert_eq!(read_text::<Config>(text).1.len(), problems, "{text}");
        }
    }

    /// Writes the colour of every triangle, which way is up, and nothing else.
    const COLORS: Exporter = Exporter {
        name: "colors",
        version: 1,
        files: &["export/colors.txt"],
        turns_axes: true,
        bytes_per_triangle: 16,
        write: |surface, store| {
            let mut draft = store.create("export/colors.txt")?;
            let failed = Error::io("write", draft.path().to_owned());
            let colors: Vec<[u8; 3]> = TriangleId::all(surface.mesh.len()).map(|t| surface.color(t)).collect();
            write!(draft, "{colors:?} {}", surface.up).map_err(failed)?;
            Ok(vec![draft.replace()?])
        },
    };

    #[test]
    fn a_format_is_known_by_its_place_in_the_list() {
        let root = raw::parse("[export]\nformats = ['colors', 'ply']").unwrap();
        let read = |exporters: &[Exporter]| {
            let document = Document::new(&root, Path::new(""), Faults::default());
            let config = Config::read_among(&Keys::of(&document, Config::OUTLINE), exporters);
            (config, document.into_faults().of_file(Path::new("")).list)
        };
        let (config, problems) = read(&[EXPORTERS, &[COLORS]].concat());
        assert_eq!((problems, config.formats.len()), (vec![], 2));
        let said: Vec<String> = config.settings().into_iter().map(|setting| setting.value).collect();
        assert_eq!(said, [r#"["colors", "ply"]"#]);
        assert_eq!(read(EXPORTERS).1[0].rule, r#"must be "ply" or "glb""#);

        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        let mesh = Mesh::new(&corners, vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        let materials = Materials {
            rows: vec![[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5], [f32::NAN; 7]].into(),
            evidence: vec![[0.0; Evidence::LEN]; 2].into(),
        };
        let (surface, store) =
            (Surface { mesh: &mesh, materials: &materials, up: DVec3::Z, place: None }, MemStore::new());
        for format in &config.formats {
            let files = (format.write)(&surface, &store).unwrap();
            assert_eq!(files.iter().map(|file| file.name.as_str()).collect::<Vec<_>>(), format.files);
        }
        let text = String::from_utf8(store.open("export/colors.txt").unwrap().to_vec()).unwrap();
        assert_eq!(text, "[[255, 0, 0], [128, 128, 128]] [0, 0, 1]");
    }
}
