//! Prints reflectance maps of some triangles of a finished run: the radiance that each sent towards each direction.
//!
//! ```text
//! cargo run --release --example maps -- pipelines/demo.toml 1000 1001 1002
//! ```
#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;
use std::path::PathBuf;

use gonio::{Result, TriangleId, direction_of, load, read_maps};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args_os().skip(1);
    let file = args.next().map(PathBuf::from).ok_or("name a pipeline file and triangles")?;
    let numbers: Vec<String> = args.map(|arg| arg.to_string_lossy().into_owned()).collect();
    let triangles: Vec<TriangleId> =
        numbers.iter().map(|number| number.parse().map(TriangleId)).collect::<Result<_, _>>()?;

    let pipeline = load(&file, &[])?;
    for (triangle, map) in triangles.iter().zip(read_maps(&pipeline, &triangles)?) {
        println!("triangle {triangle}: {} filled bins", map.bins.len());
        println!("{:>7} {:>7} {:>6}   {:>6} {:>6} {:>6}", "theta", "phi", "pixels", "red", "green", "blue");
        for (bin, sum) in &map.bins {
            let direction = direction_of(*bin);
            let theta = direction.z.acos().to_degrees();
            let phi = direction.y.atan2(direction.x).to_degrees().rem_euclid(360.0);
            let [red, green, blue] = sum.mean();
            println!("{theta:>7.1} {phi:>7.1} {:>6}   {red:>6.3} {green:>6.3} {blue:>6.3}", sum.count);
        }
    }
    Ok(())
}
