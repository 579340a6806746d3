//! Scenes of every planform, extent and fidelity, with random parameters from a fixed seed.

use crate::Case;
use crate::place::{Place, shipped};
use crate::random::Random;
use crate::record::Record;
use slipgrid_tests::repository;

/// Kinds of scenes by method, and the number of scenes of each kind.
const KINDS: [(&str, usize); 9] = [
    ("flat", 8),
    ("plane-cell", 80),
    ("plane-sample", 40),
    ("space-cell", 94),
    ("space-strip", 8),
    ("plane-time-cell", 30),
    ("plane-time-sample", 20),
    ("space-time", 12),
    ("reference", 1),
];

/// Scenes that take more than ten seconds of one core, by kind and number.
const SLOW: [(&str, usize); 1] = [("space-strip", 2)];

/// Every `QUICK_SHARE`-th scene is compared in every run.
const QUICK_SHARE: usize = 12;

/// Materials: a soft polymer, one like polyethylene on cast iron, and a stiff one with friction proportional to load.
const MATERIALS: [&str; 3] = [
    "youngs_modulus_gpa = 0.048\ndensity_g_cm3 = 1.1\n[material.friction]\nstatic_mean = 0.65\ndynamic_mean = 0.6\nrelative_std = 0.08\n\
     [material.area_law]\npressure_mpa = [0.15, 0.3, 0.6, 1.0, 3.0]\nfactor = [1.0, 0.93, 0.84, 0.75, 0.4]\n",
    "youngs_modulus_gpa = 0.38\nyoungs_modulus_std_gpa = 0.08\ndensity_g_cm3 = 0.9\n[material.friction]\nstatic_mean = 0.30\ndynamic_mean = 0.27\nrelative_std = 0.05\n\
     [material.area_law]\npressure_mpa = [0.7, 1.3, 2.6, 10.0]\nfactor = [1.0, 0.96, 0.90, 0.60]\n",
    "youngs_modulus_gpa = 2.5\ndensity_g_cm3 = 1.3\n[material.friction]\nstatic_mean = 0.2\ndynamic_mean = 0.17\nrelative_std = 0.0\n",
];

pub fn cases() -> Vec<Case> {
    let mut random = Random::new(54);
    let drawn = KINDS.iter().flat_map(|(kind, count)| (0..*count).map(move |number| (*kind, number)));
    let mut cases: Vec<Case> = drawn
        .filter_map(|(kind, number)| {
            let text = scene(kind, &mut random);
            if SLOW.contains(&(kind, number)) {
                return None;
            }
            let quick = number % QUICK_SHARE == 0 && !matches!(kind, "space-time" | "space-strip" | "reference");
            Some(Case::new(format!("{kind}-{number:02}"), quick, move || {
                let place = Place::with(&[("scene.toml", &text)]);
                let mut record = Record::new();
                place.run("simulate @scene.toml --json", &mut record);
                record
            }))
        })
        .collect();
    for name in shipped("scene-") {
        cases.push(Case::new(name.clone(), true, move || {
            let mut record = Record::new();
            let place = Place::new();
            let scene = repository().join("designs").join(&name).with_extension("toml");
            place.run(&format!("simulate {} --json -o @out", scene.display()), &mut record);
            place.record_folder("out", &mut record);
            record
        }));
    }
    cases
}

/// Creates a scene file.
fn scene(kind: &str, random: &mut Random) -> String {
    let in_time = kind.contains("time") || kind == "reference";
    let in_space = kind.starts_with("space");
    let material = (random.next() % 3) as usize;
    let block_um = if in_space { 20.0 } else { *random.choose(&[&10.0, &20.0, &5.0]) };
    let block_um = if in_time { 20.0 } else { block_um };
    let heaviest = [0.9, 2.6, 8.0][material];
    let pattern = if kind == "flat" { String::new() } else { pattern(in_space, in_time, block_um, random) };
    let light = random.between(0.1 * heaviest, 0.5 * heaviest, 0.01);
    let pressures = if in_time { format!("[{light}]") } else { format!("[{light}, {heaviest}]") };
    let extent = match kind {
        "plane-sample" | "plane-time-sample" => "sample",
        "space-strip" => "strip",
        "flat" => *random.choose(&[&"cell", &"sample"]),
        _ => "cell",
    };
    let fidelity = match kind {
        "reference" => "reference",
        _ if in_time => "dynamic",
        _ => "steady",
    };
    let length_um = random.between(800.0, if in_time || kind == "space-strip" { 1200.0 } else { 4000.0 }, 10.0);
    let layer = if in_time || kind == "space-strip" {
        "layer_um = 60.0\n".to_owned()
    } else {
        match random.next() % 4 {
            0 => "layer_um = 200.0\n".to_owned(),
            1 => format!("thickness_mm = {}\n", random.between(0.5, 9.0, 0.1)),
            _ => String::new(),
        }
    };
    let mut run = format!("fidelity = \"{fidelity}\"\nextent = \"{extent}\"\nseed = {}\n", random.next() % 9);
    if in_time {
        run += "sliding_um = 0.1\n";
        run += random.choose(&["", "warm_start = false\n", "mu_stderr = 0.004\n"]);
    } else if random.chance(0.2) && kind != "space-strip" {
        run += "refine = true\n";
    }
    format!(
        "name = \"{kind}\"\n[material]\n{}{pattern}[sample]\nlength_um = {length_um}\nblock_um = {block_um}\n{layer}[load]\n\
         pressure_mpa = {pressures}\nspeed_mm_s = {}\n[run]\n{run}",
        MATERIALS[material],
        random.choose(&[&"2.0", &"0.5", &"1.0"]),
    )
}

/// Creates a table `[pattern]`.
fn pattern(in_space: bool, in_time: bool, block_um: f64, random: &mut Random) -> String {
    let planform = if in_space {
        *random.choose(&[&"groove", &"square", &"rectangle", &"disc", &"polygon", &"crosshatch"])
    } else {
        "groove"
    };
    let widest = if in_space || in_time || block_um < 10.0 { 140.0 } else { 400.0 };
    // Whole blocks in half of the patterns: then nothing is stretched.
    let step = if random.chance(0.5) { block_um } else { 0.5 };
    let width = random.between(2.0 * block_um, widest, step);
    let spacing = random.between(3.0 * block_um, if in_space { 160.0 } else { 2.0 * widest }, step);
    let deepest = if in_time { 40.0 } else { 60.0 };
    let depth = random.between(2.0, deepest, 0.1);
    let mut text = format!(
        "[pattern]\nplanform = \"{planform}\"\nwidth_um = {width}\nspacing_um = {spacing}\ndepth_um = {depth:.1}\n"
    );
    match planform {
        "rectangle" => text += &format!("length_um = {}\n", random.between(40.0, 140.0, 1.0)),
        "polygon" => text += "vertices_um = [[0, 0], [100, 10], [80, 90], [10, 60]]\n",
        "crosshatch" => text += &format!("crossing_angle_deg = {}\n", random.choose(&[&"90.0", &"60.0"])),
        _ => {}
    }
    if in_space && planform == "groove" {
        text += &format!("angle_deg = {}\n", random.choose(&[&"90.0", &"45.0"]));
    } else if in_space && planform != "crosshatch" {
        text += &format!("arrangement = \"{}\"\n", random.choose(&[&"square", &"staggered", &"hexagonal"]));
        if random.chance(0.2) {
            text += "sliding_angle_deg = 90.0\n";
        }
    }
    if random.chance(0.35) {
        let height = random.between(0.02, 0.3, 0.01);
        let profile = random.choose(&[&"round", &"flat", &"ramp"]);
        text +=
            &format!("rim_height_um = {height:.2}\nrim_width_um = {}\nrim_profile = \"{profile}\"\n", 2.0 * block_um);
        if random.chance(0.3) {
            text += "rim_height_std_um = 0.02\n";
        }
    }
    text
}
