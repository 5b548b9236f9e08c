//! Every key of every section: its default is good, its effect is known, and another value shows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use tempfile::TempDir;

use super::{DEMO, TEMPLATE, load_text, scene};
use crate::config::{Effect, Setting, Value, raw};
use crate::pipeline::sections::{NEVER_CHANGE_A_RESULT, SECTIONS};

/// Another value for every key.
const OTHERS: [(&str, &str); 49] = [
    ("synth.into", "there"),
    ("synth.city.seed", "36"),
    ("synth.city.triangles", "6000"),
    ("synth.city.frames", "61"),
    ("synth.city.width", "100"),
    ("synth.city.height", "100"),
    ("synth.city.supersampling", "1"),
    ("synth.city.sun_elevation_deg", "30"),
    ("synth.city.sun_azimuth_deg", "30"),
    ("synth.city.suns", "[[30, 10], [40, 90]]"),
    ("synth.city.sky", "[0.1, 0.1, 0.1]"),
    ("synth.city.jpeg_quality", "90"),
    ("synth.city.world", "real"),
    ("scene.mesh", "other.ply"),
    ("scene.images", "other"),
    ("scene.masks", "other"),
    ("scene.up", "[0, -1, 0]"),
    ("scene.crs", "EPSG:32633"),
    ("scene.offset", "[412000, 5812000, 0]"),
    ("scene.poses.format", "opensfm"),
    ("scene.poses.path", "other"),
    ("decode.transfer", "linear"),
    ("decode.gamma", "2.4"),
    ("decode.downscale", "2"),
    ("decode.exposure", "as_is"),
    ("cast.tile", "64"),
    ("gather.group", "5"),
    ("infer.estimator", "fit"),
    ("infer.model", "other.onnx"),
    ("infer.backend", "embedded"),
    ("infer.library", "other.ply"),
    ("infer.batch", "7"),
    ("infer.min_bins", "4"),
    ("merge.fill", "false"),
    ("light.mode", "known"),
    ("light.sun", "[1, 0, 0]"),
    ("light.color", "[1, 1, 0.5]"),
    ("light.sky", "[0.1, 0.1, 0.1]"),
    ("light.white", "1.5"),
    ("light.place", "[52.5, 13.4]"),
    ("light.time", "2014-05-26T12:45:30"),
    ("light.north", "[1, 0, 0]"),
    ("export.formats", "[\"glb\"]"),
    ("run.work", "elsewhere"),
    ("run.memory", "3GiB"),
    ("run.threads", "3"),
    ("run.grace", "5"),
    ("run.verify", "true"),
    ("run.holdout", "\"every 4th\""),
];

/// What else must be set for a key to be set.
const WITH: [(&str, &str); 7] = [
    ("decode.gamma", "decode.transfer=gamma"),
    ("infer.estimator", "light.mode=known"),
    ("infer.estimator", "light.sun=[0, 0, 1]"),
    ("light.mode", "light.sun=[0, 0, 1]"),
    ("light.place", "light.mode=ephemeris"),
    ("light.time", "light.mode=ephemeris"),
    ("light.north", "light.mode=ephemeris"),
];

/// A folder in which all paths of [`OTHERS`] lead somewhere.
fn folder() -> TempDir {
    let dir = scene();
    fs::create_dir(dir.path().join("other")).unwrap();
    for file in ["other.ply", "other.onnx", "other/cameras.bin", "other/images.bin", "sparse/0/reconstruction.json"] {
        fs::write(dir.path().join(file), "").unwrap();
    }
    dir
}

/// The settings of a file in which `key` has this value, by effect.
fn settings(dir: &TempDir, key: &str, value: Option<&str>) -> BTreeSet<(String, Effect, String)> {
    let text = if key.starts_with("synth.city") { DEMO } else { TEMPLATE };
    let path = value.map(|value| dir.path().join(value)).filter(|path| path.exists());
    let value = path.map_or(value.map(str::to_owned), |path| Some(path.display().to_string()));
    let with = WITH.iter().filter(|(of, _)| *of == key).map(|(_, set)| (*set).to_owned());
    let sets: Vec<String> = with.chain(value.map(|value| format!("{key}={value}"))).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let pipeline = load_text(dir, text.as_bytes(), &sets).unwrap();
    pipeline.all_settings().into_iter().map(|Setting { key, value, effect }| (key, effect, value)).collect()
}

/// Every key, as `section.key`.
fn all_keys() -> BTreeSet<String> {
    let keys = SECTIONS.iter().flat_map(|section| section.keys.iter().map(move |key| (section, key)));
    keys.filter(|(_, key)| key.value != Value::Section).map(|(s, key)| format!("{}.{}", s.name, key.name)).collect()
}

#[test]
fn another_value_of_any_key_shows_in_the_settings_that_depend_on_it() {
    let dir = folder();
    let named: BTreeSet<String> = OTHERS.iter().map(|(key, _)| (*key).to_owned()).collect();
    assert_eq!(named, all_keys(), "the table of other values against the keys of all sections");
    let mut without_effect = BTreeSet::new();
    for (key, value) in OTHERS {
        // What must be set with the key is set before, too.
        let (before, after) = match key {
            // A gamma must be there where it is meant.
            "decode.gamma" => (settings(&dir, key, Some("2.2")), settings(&dir, key, Some(value))),
            "synth.into" => (made_in("here"), made_in("there")),
            _ => (settings(&dir, key, None), settings(&dir, key, Some(value))),
        };
        let of_key = |all: &BTreeSet<(String, Effect, String)>| -> BTreeSet<(Effect, String)> {
            all.iter().filter(|(name, ..)| name == key).map(|(_, effect, value)| (*effect, value.clone())).collect()
        };
        let others = |all: &BTreeSet<(String, Effect, String)>| -> BTreeSet<(String, Effect, String)> {
            all.iter().filter(|(name, ..)| name != key).cloned().collect()
        };
        assert!(!of_key(&before).is_empty(), "{key} is among no settings");
        assert_eq!(others(&before), others(&after), "{key} changes what another key says");
        assert!(of_key(&before).is_disjoint(&of_key(&after)), "{key} = {value} changes nothing");
        if of_key(&before).iter().any(|(effect, _)| *effect == Effect::Nothing) {
            assert_eq!(of_key(&before).len(), 1, "{key} has an effect, and none");
            without_effect.insert(key);
        }
    }
    assert_eq!(without_effect, BTreeSet::from(NEVER_CHANGE_A_RESULT), "keys that never change a result");
}

/// The settings of a city that is made in a folder, which no input is taken from.
fn made_in(into: &str) -> BTreeSet<(String, Effect, String)> {
    let (dir, text) = (folder(), format!("{TEMPLATE}\n[synth]\ninto = \"{into}\"\n"));
    let pipeline = load_text(&dir, text.as_bytes(), &[]).unwrap();
    let here = dir.path().display().to_string();
    let setting = |Setting { key, value, effect }| (key, effect, value.replace(&here, ""));
    pipeline.all_settings().into_iter().map(setting).collect()
}

#[test]
fn settings_are_the_keys() {
    let dir = folder();
    let text = format!("{TEMPLATE}\n[synth]\ninto = \"here\"\n");
    let pipeline = load_text(&dir, text.as_bytes(), &[]).unwrap();
    let settings: BTreeSet<String> = pipeline.all_settings().into_iter().map(|setting| setting.key).collect();
    assert_eq!(settings, all_keys());
    // Whatever an effect asks for is there once.
    for effect in [
        Effect::Look,
        Effect::Cast,
        Effect::Infer,
        Effect::Light,
        Effect::Merge,
        Effect::Place,
        Effect::Axes,
        Effect::Formats,
    ] {
        let mut counts = BTreeMap::new();
        pipeline.ingredients(effect).for_each(|(key, _)| *counts.entry(key).or_insert(0) += 1);
        assert!(!counts.is_empty() && counts.values().all(|count| *count == 1), "{effect:?}: {counts:?}");
    }
}

#[test]
fn sections_and_keys_are_listed_once_and_hold_toml() {
    let names: BTreeSet<&str> = SECTIONS.iter().map(|section| section.name).collect();
    assert_eq!(names.len(), SECTIONS.len());
    for section in SECTIONS {
        let keys: BTreeSet<&str> = section.names().into_iter().collect();
        assert_eq!(keys.len(), section.keys.len(), "{}", section.name);
        assert!(section.former.iter().all(|former| !keys.contains(former.name)), "{}", section.name);
        for key in section.keys {
            match key.value {
                Value::Default(text) | Value::Needed(text) | Value::Optional(text) => {
                    assert!(raw::value(text).is_some(), "{}.{}: {text}", section.name, key.name);
                }
                Value::Section => assert!(names.contains(format!("{}.{}", section.name, key.name).as_str())),
            }
        }
    }
}
