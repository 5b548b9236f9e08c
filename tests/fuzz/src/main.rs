//! All fuzz targets in one program, so that gonio is built and linked once. `GONIO_FUZZ` names the target; `seeds` in its
//! place writes the seeds of all targets anew, and `check` reads them. `run` beside `Cargo.toml` starts it.
#![no_main]

mod input;
mod memory;
mod seeds;
mod targets;

use std::sync::OnceLock;
use std::{env, panic, process};

use libfuzzer_sys::fuzz_target;
use targets::{TARGETS, Target};

#[global_allocator]
static COUNTED: memory::Counted = memory::Counted;

static CHOSEN: OnceLock<&Target> = OnceLock::new();

fuzz_target!(init: choose(), |bytes: &[u8]| {
    CHOSEN.get().unwrap().run(bytes);
});

fn choose() {
    pass_over_panics_of_decoders();
    let name = env::var("GONIO_FUZZ").unwrap_or_default();
    match name.as_str() {
        "seeds" => seeds::write(),
        "check" => seeds::check(),
        "list" => TARGETS.iter().for_each(|target| println!("{}", target.name)),
        name => match TARGETS.iter().find(|target| target.name == name) {
            Some(target) => return CHOSEN.set(target).unwrap_or_default(),
            None => {
                eprintln!("GONIO_FUZZ is {name:?}; the targets are {}", TARGETS.map(|target| target.name).join(", "));
                process::exit(2);
            }
        },
    }
    process::exit(0);
}

/// A panic ends the program before anything can catch it. gonio catches those of the decoders of images.
fn pass_over_panics_of_decoders() {
    let ending = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let file = info.location().map_or("", |at| at.file());
        if !["image-", "png-", "tiff-", "exr-", "zune-jpeg-"].iter().any(|name| file.contains(&format!("/{name}"))) {
            ending(info);
        }
    }));
}
