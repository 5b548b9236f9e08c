//! The recipes of the reduce side: what has to be inferred again when a few frames have changed.

use super::Pipeline;
use super::scene::Loaded;
use crate::base::Result;
use crate::base::key::{Key, KeyBuilder};
use crate::disk::{Manifest, Recipe, Store};
use crate::model::Estimator;
use crate::shard::format::Hash;
use crate::shard::{Blocks, format, rows};
use crate::stages::gather::{Group, open_blocks};
use crate::stages::light;
use crate::stages::merge::{self, TABLES};
use crate::stages::shards::{SHARD, Shard};

/// The part of a shard's recipe that stands for its blocks.
const BLOCKS: &str = "observations";

/// The shards below `count` that something was observed in. `with` adds what turns their blocks into rows.
fn shards(blocks: &[Blocks], count: u32, with: impl Fn(Recipe) -> Recipe) -> Vec<Shard> {
    let shard = |number: u32| {
        let mut hashes: Vec<Hash> = blocks.iter().flat_map(|unit| unit.of(number)).collect();
        // Which unit a block belongs to has no part in what comes of it.
        hashes.sort_unstable();
        let all = hashes.iter().fold(KeyBuilder::new("gonio blocks 1"), |key, hash| key.field(hash)).finish();
        let recipe = || with(Recipe::new(format!("{SHARD} {number}")).with(BLOCKS, all));
        (!hashes.is_empty()).then(|| Shard { number, recipe: recipe() })
    };
    (0..count).filter_map(shard).collect()
}

/// The shards of a scene that these groups, as far as they are done, saw anything in.
///
/// # Errors
/// A list of blocks that cannot be read.
pub fn of_groups(
    pipeline: &Pipeline,
    estimator: &dyn Estimator,
    store: &dyn Store,
    manifest: &Manifest,
    groups: &[Group],
    loaded: &Loaded,
) -> Result<Vec<Shard>> {
    let done = groups.iter().filter_map(|group| manifest.files(&group.recipe.unit()));
    let blocks: Vec<Blocks> = done.map(|files| open_blocks(store, files)).collect::<Result<_>>()?;
    let count = (loaded.mesh.len() as u32).div_ceil(format::SHARD);
    Ok(shards(&blocks, count, inferred_with(pipeline, estimator, loaded.mesh_key)))
}

/// Adds what turns blocks into rows: the estimator, its engine, settings and formats. In a known light also that, and the
/// mesh, which casts shadows.
fn inferred_with<'a>(
    pipeline: &'a Pipeline,
    estimator: &'a dyn Estimator,
    mesh: Key,
) -> impl Fn(Recipe) -> Recipe + 'a {
    let (model, engine) = (estimator.key(), estimator.engine());
    let lit = move |recipe: Recipe| {
        let light::Config { mode: _, sun, color, sky } = &pipeline.light;
        let recipe = recipe.with("light.sun", format!("{sun:?}")).with("light.color", format!("{color:?}"));
        let recipe = recipe.with("light.sky", format!("{sky:?}")).with("scene.mesh", mesh);
        // The sky is the half that is up.
        recipe.with("export.up", format!("{:?}", pipeline.export.up))
    };
    let wants_light = estimator.contract().light.wanted();
    move |recipe| {
        let recipe = if wants_light { lit(recipe) } else { recipe };
        recipe
            .with("infer.model", model)
            .with("infer.backend", &engine)
            .with("merge.min_bins", pipeline.merge.min_bins)
            .with("format", format!("{}.{}", format::VERSION, rows::VERSION))
    }
}

/// The recipe of the tables that are made of these shards.
pub fn tables(pipeline: &Pipeline, mesh: Key, shards: &[Shard]) -> Recipe {
    let start = KeyBuilder::new("gonio shards 1");
    let all = shards.iter().fold(start, |key, shard| key.field(shard.recipe.unit().as_bytes())).finish();
    Recipe::new(TABLES)
        .with("scene.mesh", mesh)
        .with("merge.fill", pipeline.merge.fill)
        .with("shards", all)
        .with("format", merge::VERSION)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;
    use crate::shard::format::Entry;

    /// Units whose blocks are given as `(shard, content)`.
    fn keys(units: &[&[(u32, u8)]], model: u8) -> Vec<Shard> {
        let store = MemStore::new();
        let entry = |&(shard, n): &(u32, u8)| Entry {
            shard,
            triangles: 1,
            records: 1,
            crc: 0,
            offset: 0,
            length: 0,
            hash: [n; 16],
        };
        let open = |(at, unit): (usize, &&[(u32, u8)])| {
            let name = at.to_string();
            Blocks::write(&store, &name, &unit.iter().map(entry).collect::<Vec<_>>()).unwrap();
            Blocks::open(&store, &name).unwrap()
        };
        shards(&units.iter().enumerate().map(open).collect::<Vec<_>>(), 9, |recipe| recipe.with("model", model))
    }

    #[test]
    fn a_shard_changes_with_its_blocks_and_with_nothing_else() {
        let before = keys(&[&[(0, 1), (2, 1)], &[(2, 7), (3, 1), (9, 1)]], 0);
        assert_eq!(before.iter().map(|s| s.number).collect::<Vec<_>>(), [0, 2, 3]);
        assert_ne!(before[0].recipe.unit(), before[2].recipe.unit(), "equal blocks of other shards");
        for (units, model, changed, why) in [
            (&[&[(2, 7), (3, 1)][..], &[(0, 1), (2, 1)]], 0, [false; 3], "units in another order"),
            (&[&[(0, 1), (2, 1), (2, 7)], &[(3, 1)]], 0, [false; 3], "blocks in other units"),
            (&[&[(0, 1), (2, 1)], &[(2, 8), (3, 1)]], 0, [false, true, false], "another block"),
            (&[&[(0, 1), (2, 1)], &[(2, 7), (2, 7), (3, 1)]], 0, [false, true, false], "a block more"),
            (&[&[(0, 1), (2, 1)], &[(3, 1), (2, 7)]], 1, [true; 3], "another model"),
        ] {
            let after = keys(units, model);
            let found: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
            assert_eq!(found, changed, "{why}");
        }
    }
}
