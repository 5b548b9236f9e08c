//! Whole runs in a known light.

use std::fs;
use std::path::Path;

use gonio::internals::codec::tables::npy;
use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

/// The city's sun and sky; a list has no blanks here, since arguments are told apart by them.
const LIGHT: &str = "infer.estimator=fit light.mode=known light.sky=[0.16,0.19,0.24] \
                     light.sun=[-0.45634598,-0.50682354,0.73135370]";

fn sets(sets: &str) -> String {
    sets.split_whitespace().map(|set| format!(" --set {set}")).collect()
}

fn run(dir: &TempDir, work: &str, sets: &str) -> Ran {
    let ran = Ran::gonio(dir.path(), &format!("run p.toml --set run.work={work}{}", self::sets(sets)));
    ran.ends(0);
    ran
}

/// Over the triangles that were seen: the mean absolute error of kd, that of the mean radiance in its place, and the share of
/// the seven components that are within one standard deviation.
fn errors(dir: &Path, work: &str) -> [f64; 3] {
    let rows = |name: &str| npy::read_rows::<7>(&dir.join(name)).unwrap();
    let (truth, found) = (rows("truth/materials.npy"), rows(&format!("{work}/materials.npy")));
    let evidence = npy::read_rows::<18>(&dir.join(work).join("evidence.npy")).unwrap();
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for ((truth, found), evidence) in truth.iter().zip(&found).zip(&evidence).filter(|(_, e)| e[9] == 0.0) {
        for c in 0..3 {
            sums[0] += f64::from((truth[c] - found[c]).abs());
            sums[1] += f64::from((truth[c] - evidence[6 + c].min(1.0)).abs());
        }
        let within = (0..7).filter(|&c| (truth[c] - found[c]).abs() <= evidence[10 + c]).count();
        sums[2] += within as f64 * 3.0 / 7.0;
        count += 3.0;
    }
    sums.map(|sum| sum / count)
}

#[test]
fn a_known_light_gives_the_colours_back() {
    let dir = city();
    run(&dir, "fit", LIGHT).says("2 (2 inferred, 0 from before)");
    run(&dir, "network", "infer.estimator=network light.mode=unknown");
    let ([fit, plain, within], [network, _, said]) = (errors(dir.path(), "fit"), errors(dir.path(), "network"));
    assert!(fit < 0.6 * plain && fit < 0.6 * network, "fit {fit}, mean radiance {plain}, network {network}");
    assert!((0.55..0.85).contains(&within) && said > 0.3, "{within} and {said} of the truths within a deviation");
    // Under other suns it is nearer to the truth than what needs no fit, and so it is under its own.
    let eval =
        format!("eval scene p.toml --truth truth/materials.npy --frames 2 --json --set run.work=fit{}", sets(LIGHT));
    let judged: Vec<serde_json::Value> = serde_json::from_str(&Ran::gonio(dir.path(), &eval).ends(0).stdout()).unwrap();
    let [fit, mean, matt] = &judged[..] else { panic!("{judged:?}") };
    let psnr = |of: &serde_json::Value| {
        let suns = of["suns"].as_array().unwrap().iter().map(|sun| sun.as_f64().unwrap());
        (of["same_light"].as_f64().unwrap(), suns.sum::<f64>())
    };
    let (fit, mean, matt) = (psnr(fit), psnr(mean), psnr(matt));
    assert!(fit.0 > matt.0 && matt.0 > mean.0 && fit.1 > matt.1 && matt.1 > mean.1, "{fit:?} {matt:?} {mean:?}");
    // From what the network says it goes as well, and as far.
    run(&dir, "both", &format!("{LIGHT} infer.estimator=network+fit infer.backend=embedded"));
    let [both, ..] = errors(dir.path(), "both");
    assert!(both < 0.6 * plain && outputs(&dir.path().join("fit")) != outputs(&dir.path().join("both")), "{both}");
    // One thread and small tiles give the same bytes, and another sun is another answer.
    run(&dir, "again", &format!("{LIGHT} run.threads=1 cast.tile=8 infer.batch=7"));
    assert!(outputs(&dir.path().join("fit")) == outputs(&dir.path().join("again")));
    let other = run(&dir, "fit", &format!("{LIGHT} light.color=[0.9,1,1]"));
    other.says("10 (0 cast, 10 from before").says("2 (2 inferred, 0 from before)");
    assert!(outputs(&dir.path().join("fit")) != outputs(&dir.path().join("again")));
}

#[test]
fn photographs_that_are_left_out_judge_the_materials() {
    let dir = city();
    run(&dir, "all", LIGHT);
    let eval = |work: &str, more: &str| {
        Ran::gonio(dir.path(), &format!("eval scene p.toml --json --set run.work={work}{}{more}", sets(LIGHT)))
    };
    eval("all", "").ends(1).says("nothing to judge by").says("holdout = \"every 4th\"");
    let held_out =
        fs::read_to_string(dir.path().join("p.toml")).unwrap().replace("[run]\n", "[run]\nholdout = \"every 4th\"\n");
    fs::write(dir.path().join("p.toml"), held_out).unwrap();
    run(&dir, "some", LIGHT).says("8 (8 cast, 0 from before");
    let ran = eval("some", " --beside all/materials.npy");
    let told: serde_json::Value = serde_json::from_str(&ran.ends(0).stdout()).unwrap();
    let told = &told["held_out"];
    let psnr = |name: &str| told["estimates"][name]["psnr"].as_f64().unwrap();
    assert_eq!((told["frames"].as_u64(), told["psnr"].as_f64()), (Some(2), Some(psnr("estimate"))));
    assert!((0.5..=1.0).contains(&told["ssim"].as_f64().unwrap()), "{told}");
    // A photograph is foretold better than by colours that stay as they are, and less well than by what saw it.
    let (estimate, mean, beside) = (psnr("estimate"), psnr("mean radiance"), psnr("beside"));
    assert!(estimate > mean + 3.0 && beside > estimate, "{told}");
    let unlit = "eval scene p.toml --set run.work=some --set light.mode=unknown";
    Ran::gonio(dir.path(), unlit).ends(1).says("no light is known").says("--beside");
    // The truth is judged by beside it.
    let ran = eval("some", " --truth truth/materials.npy --frames 1");
    let judged: serde_json::Value = serde_json::from_str(&ran.ends(0).stdout()).unwrap();
    assert_eq!(judged[0]["held_out"]["psnr"], told["psnr"]);
    Ran::gonio(dir.path(), "check p.toml --set run.holdout=every4")
        .ends(2)
        .says("run.holdout: must be as \"every 4th\"");
}

#[test]
fn the_light_alone_is_found_and_found_anew() {
    let dir = city();
    Ran::gonio(dir.path(), "synth city --out big --triangles 5000 --frames 8 --width 320 --height 240").ends(0);
    let at =
        "light p.toml --set scene.mesh=big/mesh.ply --set scene.images=big/images --set scene.poses.path=big/sparse/0";
    let found = || std::fs::read(dir.path().join("work/p/light.json")).unwrap();
    Ran::gonio(dir.path(), at)
        .ends(0)
        .says("sun            [-0.")
        .says("gains 0.9")
        .says("light.json")
        .says("light.png");
    let first = found();
    assert!(dir.path().join("work/p/light.png").exists() && !dir.path().join("work/p/report.json").exists());
    Ran::gonio(dir.path(), at).ends(0);
    assert_eq!(found(), first);
    // Found anew, it is found of the same photographs.
    Ran::gonio(dir.path(), &format!("{at} --again")).ends(0).says("sun            [-0.");
    assert_eq!(found(), first);
    let explain = at.replace("light p", "explain p");
    Ran::gonio(dir.path(), &explain).ends(0).says("looks          none").says("lights         none").says("8 of 8");
    let nothing = "light p.toml --set light.mode=unknown --set decode.exposure=as_is";
    Ran::gonio(dir.path(), nothing).ends(1).says("nothing is to be found");
}

#[test]
fn a_fit_without_a_light_is_refused_at_its_line() {
    let dir = city();
    let ran = Ran::gonio(dir.path(), "check p.toml --set infer.estimator=fit --set light.mode=unknown");
    ran.ends(2).says("infer.estimator: needs a light");
    let ran = Ran::gonio(dir.path(), "check p.toml --set infer.estimator=fit --set light.mode=known");
    ran.ends(2).says("light.sun: must point towards the sun");
}
