//! Files that programs leave beside a mesh or its poses to say where on the earth they lie.
//!
//! ```text
//! metadata.xml   <SRS>EPSG:32633</SRS> <SRSOrigin>x,y,z</SRSOrigin>     ContextCapture, Metashape: in a folder above tiles too
//! *offset.xyz    x y z                                                  Pix4D
//! *.prj          the system, as well-known text                         Pix4D, ArcGIS
//! ```

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::base::input::Input;
use crate::scene::georeference::{Crs, Georeference};

/// The most bytes of such a file.
const MOST: u64 = 1 << 16;

/// The most files of a folder whose names are looked at.
const LISTED: usize = 1 << 16;

/// The folders above tiles in which their `metadata.xml` is looked for.
const ABOVE: usize = 3;

/// Where what lies at a path lies on the earth, as files beside it say. What cannot be read says nothing.
pub(crate) fn beside(path: &Path) -> Option<Georeference> {
    let folder = if path.is_dir() { path } else { path.parent()? };
    let above = folder.ancestors().take(ABOVE);
    above.filter_map(|folder| of_metadata(&text(&folder.join("metadata.xml"))?)).next().or_else(|| of_pair(folder))
}

/// What a `metadata.xml` says.
fn of_metadata(text: &str) -> Option<Georeference> {
    let within = |name: &str| {
        let (_, rest) = text.split_once(&format!("<{name}>"))?;
        rest.split_once(&format!("</{name}>")).map(|(words, _)| words)
    };
    Some(Georeference { crs: within("SRS").and_then(Crs::of_definition), offset: three(within("SRSOrigin")?)? })
}

/// What the one `*offset.xyz` and the one `*.prj` of a folder say.
fn of_pair(folder: &Path) -> Option<Georeference> {
    let one = |ending: &str| {
        let ends = |path: &PathBuf| path.to_string_lossy().to_ascii_lowercase().ends_with(ending);
        let mut found = fs::read_dir(folder).ok()?.take(LISTED).flatten().map(|entry| entry.path()).filter(ends);
        found.next().filter(|_| found.next().is_none())
    };
    let crs = one(".prj").and_then(|file| Crs::of_definition(&text(&file)?));
    let offset = one("offset.xyz").and_then(|file| three(&text(&file)?));
    (crs.is_some() || offset.is_some()).then(|| Georeference { crs, offset: offset.unwrap_or_default() })
}

/// Three finite numbers, with spaces or commas between them.
fn three(text: &str) -> Option<[f64; 3]> {
    let words = text.split([' ', ',', ';', '\t', '\r', '\n']).filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let three: [f64; 3] = numbers.try_into().ok()?;
    three.iter().all(|number| number.is_finite()).then_some(three)
}

fn text(file: &Path) -> Option<String> {
    let mut text = String::new();
    let file = Input::open(file).ok().filter(|file| file.length() <= MOST)?;
    file.take(MOST).read_to_string(&mut text).ok()?;
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)], path: &str) -> Option<(Option<String>, [f64; 3])> {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::create_dir_all(dir.path().join(name).parent().unwrap()).unwrap();
            fs::write(dir.path().join(name), text).unwrap();
        }
        let found = beside(&dir.path().join(path))?;
        Some((found.crs.map(|crs| crs.to_string()), found.offset))
    }

    const METADATA: (&str, &str) = (
        "metadata.xml",
        "<?xml version=\"1.0\"?>\n<ModelMetadata version=\"1\">\n<SRS>EPSG:32633+5773</SRS>\n\
         <SRSOrigin>412000,5812000.5,-3</SRSOrigin></ModelMetadata>",
    );

    #[test]
    fn tiles_have_it_above_them() {
        let wanted = Some((Some("EPSG:32633".to_owned()), [412_000.0, 5_812_000.5, -3.0]));
        let tile = ("Data/Tile_1/Tile_1.obj", "");
        assert_eq!(found(&[METADATA, tile], tile.0), wanted);
        assert_eq!(found(&[METADATA, tile], "Data/Tile_*/*.obj"), wanted);
        assert_eq!(found(&[METADATA, tile], "."), wanted);
        let unnamed = ("metadata.xml", "<SRS>ENU:52,13</SRS><SRSOrigin>1,2,3</SRSOrigin>");
        assert_eq!(found(&[unnamed], "mesh.obj"), Some((Some("ENU:52,13".to_owned()), [1.0, 2.0, 3.0])));
        for text in
            ["<SRS>EPSG:32633</SRS>", "<SRSOrigin>1,2</SRSOrigin>", "<SRSOrigin>1,2,inf</SRSOrigin>", "<SRSOrigin>"]
        {
            assert_eq!(found(&[("metadata.xml", text)], "mesh.obj"), None, "{text}");
        }
    }

    #[test]
    fn an_offset_and_a_system_lie_beside_the_mesh() {
        let (offset, system) =
            (("a_offset.xyz", "412000.000 5812000.000 0.000\n"), ("a_wkt.prj", "PROJCS[\"UTM 33N\"]"));
        let at = [412_000.0, 5_812_000.0, 0.0];
        assert_eq!(found(&[offset, system], "mesh.obj"), Some((Some("EPSG:32633".to_owned()), at)));
        assert_eq!(found(&[offset], "mesh.obj"), Some((None, at)));
        assert_eq!(found(&[system], "mesh.obj"), Some((Some("EPSG:32633".to_owned()), [0.0; 3])));
        // Of two, nobody knows which is meant.
        assert_eq!(found(&[offset, ("b_offset.xyz", "1 2 3")], "mesh.obj"), None);
        assert_eq!(found(&[("a.prj", "LOCAL_CS[\"Local\"]"), ("a_offset.xyz", "one")], "mesh.obj"), None);
        assert_eq!(found(&[], "mesh.obj"), None);
    }
}
