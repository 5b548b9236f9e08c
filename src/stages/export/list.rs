//! The list of exporters.

use super::exporter::Exporter;
use super::glb::GLB;
use super::ply::PLY;

/// Every format that gonio exports.
pub(crate) const EXPORTERS: &[Exporter] = &[PLY, GLB];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_no_two_exporters_own_a_file() {
        let plain = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        assert!(EXPORTERS.iter().all(|exporter| plain(exporter.name)));
        let mut files: Vec<&str> = EXPORTERS.iter().flat_map(|exporter| exporter.files).copied().collect();
        let all = files.len();
        files.sort_unstable();
        files.dedup();
        assert!(files.len() == all && files.iter().all(|file| file.starts_with("export/")));
    }
}
