//! The recipes of shards: what has to be inferred over when a few frames have changed.

use crate::base::ids::ShardId;
use crate::base::key::{Key, KeyBuilder};
use crate::base::{PhaseName, Result};
use crate::config::Effect;
use crate::disk::Recipe;
use crate::disk::{Ledger, Store};
use crate::phases::cause::FORMAT;
use crate::phases::known::Known;
use crate::shard::format::Hash;
use crate::shard::{Blocks, format, rows};
use crate::stages::gather::open_blocks;

/// The recipes of those shards that something was observed in. `with` adds to the hash of a shard's blocks what turns
/// them into rows.
fn recipes(blocks: &[Blocks], shards: impl Iterator<Item = ShardId>, with: impl Fn(Recipe) -> Recipe) -> Vec<Recipe> {
    let recipe = |shard: ShardId| {
        let mut hashes: Vec<Hash> = blocks.iter().flat_map(|unit| unit.of(shard)).collect();
        // Which group a block belongs to has no part in what comes of it.
        hashes.sort_unstable();
        let all = hashes.iter().fold(KeyBuilder::new("gonio blocks 1"), |key, hash| key.field(hash)).finish();
        let recipe = || Recipe::new(PhaseName::Infer, shard.to_string()).with(PhaseName::Cast.as_str(), all);
        (!hashes.is_empty()).then(|| with(recipe()))
    };
    shards.filter_map(recipe).collect()
}

/// The recipes of the shards that the groups, as far as they are done, saw anything in, in the order of the shards.
///
/// # Errors
/// A list of blocks that cannot be read.
pub(super) fn recipes_of(known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Vec<Recipe>> {
    let surveyed = known.surveyed()?;
    let done = surveyed.groups.all().iter().filter_map(|group| ledger.files(&group.recipe.unit()));
    let blocks: Vec<Blocks> = done.map(|files| open_blocks(store, &files)).collect::<Result<_>>()?;
    let shards = ShardId::all(surveyed.scene.mesh.len());
    Ok(recipes(&blocks, shards, inferred_with(known, surveyed.scene.mesh_key)))
}

/// Adds what turns blocks into rows: the estimator, its engine, settings and formats. In a light also that, and the mesh, which
/// casts shadows.
fn inferred_with<'a>(known: &'a Known<'_>, mesh: Key) -> impl Fn(Recipe) -> Recipe + 'a {
    let (pipeline, estimator) = (known.pipeline, &*known.estimator);
    let (model, engine) = (estimator.key(), estimator.engine());
    let lit = estimator.contract().light.wanted();
    let found = known.surveyed().ok().filter(|_| pipeline.estimates_light()).and_then(|s| s.light.light_key());
    move |recipe| {
        let recipe = if lit {
            let recipe = recipe.with("scene.mesh", mesh).with_all(pipeline.ingredients(Effect::Light));
            recipe.with_or_without(PhaseName::Light.as_str(), found)
        } else {
            recipe
        };
        recipe
            .with("infer.model", model)
            .with("infer.backend", &engine)
            .with_all(pipeline.ingredients(Effect::Infer))
            .with(FORMAT, format!("{}.{}", format::VERSION, rows::VERSION))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;
    use crate::shard::format::Entry;

    /// Units whose blocks are given as `(shard, content)`.
    fn keys(units: &[&[(u32, u8)]], model: u8) -> Vec<Recipe> {
        let store = MemStore::new();
        let entry = |&(shard, n): &(u32, u8)| Entry {
            shard: ShardId(shard),
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
        recipes(&units.iter().enumerate().map(open).collect::<Vec<_>>(), (0..9).map(ShardId), |recipe| {
            recipe.with("model", model)
        })
    }

    #[test]
    fn a_shard_changes_with_its_blocks_and_with_nothing_else() {
        let before = keys(&[&[(0, 1), (2, 1)], &[(2, 7), (3, 1), (9, 1)]], 0);
        assert_eq!(before.iter().map(Recipe::what).collect::<Vec<_>>(), ["0", "2", "3"]);
        assert_ne!(before[0].unit(), before[2].unit(), "equal blocks of other shards");
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
