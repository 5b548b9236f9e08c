//! The reduce side of whole runs: what is inferred again, and what is kept.

use std::fs;
use std::path::Path;

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use gonio::internals::codec::images::write_png;
use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

/// Triangles in a shard; the city has two.
const SHARD: u32 = 4096;

fn run(dir: &TempDir, work: &str, sets: &str) -> Ran {
    let sets: String = sets.split_whitespace().map(|set| format!(" --set {set}")).collect();
    // Exposures stay as they were first found, and a fresh run would find others.
    let as_is = "--set gather.group=2 --set decode.exposure=as_is --set light.mode=unknown";
    let ran = Ran::gonio(dir.path(), &format!("run p.toml --set run.work={work} {as_is}{sets}"));
    ran.ends(0);
    ran
}

/// Masks what a frame sees of the second shard.
fn mask_second_shard(dir: &Path, frame: &str) {
    Ran::gonio(dir, &format!("buffers p.toml --frame {frame}.jpg --out b.exr")).ends(0);
    let layer = read_first_flat_layer_from_file(dir.join("b.exr")).unwrap().layer_data;
    let channel = layer.channel_data.list.iter().find(|c| c.name == *"triangle").unwrap();
    let FlatSamples::U32(triangles) = &channel.sample_data else { unreachable!("triangles are whole numbers") };
    let kept: Vec<[u8; 3]> = triangles.iter().map(|&t| [if t < SHARD { 255 } else { 0 }; 3]).collect();
    assert!(triangles.iter().any(|&t| t < SHARD) && kept.contains(&[0; 3]));
    write_png(&dir.join(format!("masks/{frame}.png")), &kept, layer.size.0 as u32, layer.size.1 as u32).unwrap();
}

#[test]
fn only_what_changed_is_inferred_again() {
    let dir = city();
    fs::create_dir(dir.path().join("masks")).unwrap();
    let first = run(&dir, "whole", "scene.masks=masks");
    first.says("2 (2 inferred, 0 from before)");
    run(&dir, "whole", "scene.masks=masks").says("10 (0 cast, 10 from before").says("2 (0 inferred, 2 from before)");
    // One frame changes what it sees of one shard: its group is cast, and that shard inferred.
    mask_second_shard(dir.path(), "frame_003");
    let changed = run(&dir, "whole", "scene.masks=masks");
    changed.says("10 (2 cast, 8 from before").says("2 (1 inferred, 1 from before)");
    run(&dir, "fresh", "scene.masks=masks").says("2 (2 inferred");
    assert!(outputs(&dir.path().join("whole")) == outputs(&dir.path().join("fresh")));
    // Filling is done with the tables alone; how many bins are enough decides what is inferred.
    let filled = run(&dir, "whole", "scene.masks=masks merge.fill=false");
    filled.says("10 (0 cast, 10 from before").says("2 (0 inferred, 2 from before)");
    let fewer = run(&dir, "whole", "scene.masks=masks infer.min_bins=2");
    fewer.says("10 (0 cast, 10 from before").says("2 (2 inferred, 0 from before)");
}
