//! The key `crs` of `[scene]`.

use crate::config::raw::{Node, Toml};
use crate::config::{FromToml, Problem};
use crate::scene::georeference::Crs;

/// A coordinate reference system, as a pipeline file has it: a text, or the bare number.
pub(super) struct Written(pub(super) Crs);

impl FromToml for Written {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        let text = match node.value {
            Toml::Integer(number) => number.to_string(),
            _ => String::from_toml(node)?,
        };
        let crs: Crs = text.parse().map_err(Problem::new)?;
        if crs.is_geographic() {
            let hint = "give the system that the mesh was exported in, as \"EPSG:32633\" for UTM 33N";
            return Err(Problem::new("must have metres: this system has degrees").got(text).hint(hint));
        }
        Ok(Written(crs))
    }
}
