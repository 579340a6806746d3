//! Altitude maps: synthetic maps of several shapes, and files of other programs.

use std::fs;

use crate::Case;
use crate::place::Place;
use crate::record::Record;
use slipgrid_tests::repository;

/// Files of other programs, from the tests of the readers, with the options that they need.
const FOREIGN: [(&str, &str); 17] = [
    ("gsffile.gsf", ""),
    ("gwyddion.asc", ""),
    ("iso.npy", "--pixel-um 1 --height-unit um"),
    ("numpy-f4.npy", "--pixel-um 1 --height-unit um"),
    ("numpy-fortran.npy", "--pixel-um 1 --height-unit nm"),
    ("points.xyz", "--height-unit um --lateral-unit um"),
    ("spip.asc", ""),
    ("surface-topography-D.x3p", ""),
    ("surface-topography-F.x3p", ""),
    ("surface-topography-I.x3p", ""),
    ("surface-topography-L.x3p", ""),
    ("surfalize-binary.sdf", ""),
    ("surfalize-compressed.sur", ""),
    ("surfalize-latin1.sur", ""),
    ("surfalize-text.sdf", ""),
    ("surfalize-utf8.sur", ""),
    ("surfalize.x3p", ""),
];

/// Synthetic maps of 96 pixels: name, options of `synthesize`, and options of `surface`.
const MADE: [(&str, &str, &str); 16] = [
    ("rough", "", ""),
    ("rough, plane not subtracted", "", "--form mean"),
    ("rough, second order", "", "--form second-order"),
    ("rough, decimated", "", "--decimate 2"),
    ("rough, picked", "", "--decimate 3 --decimate-by pick"),
    ("rough, cropped", "", "--crop 10,20,40,50"),
    ("rough, spikes", "", "--despike"),
    ("smooth", "--hurst 1 --waves 2:12 --sa-um 0.5", ""),
    ("steep", "--hurst 0.4 --rms-slope 0.05", ""),
    ("grooves", "--side-mm 2 --cavities 130,370,5.2 --wall-um 20", "--cavities --period-out @period.asc"),
    ("grooves, rims", "--side-mm 0.5 --cavities 60,60,5 --rims 0.5,20 --rim-std-um 0.05", "--cavities"),
    ("grooves, ramps", "--side-mm 0.5 --cavities 60,60,5 --rims 0.5,25 --rim-profile ramp", "--cavities"),
    ("squares", "--side-mm 0.8 --cavities 80,80,8 --cavity-shape square", "--cavities --period-out @period.asc"),
    ("discs", "--side-mm 0.8 --cavities 90,70,8 --cavity-shape disc --cavity-std 3,0,0.4", "--cavities"),
    ("discs, one period", "--side-mm 0.16 --cavities 90,70,8 --cavity-shape disc", "--cavities"),
    ("no cavities", "", "--cavities"),
];

pub fn cases() -> Vec<Case> {
    let foreign = FOREIGN.iter().map(|(file, options)| {
        Case::new(*file, true, move || {
            let path = repository().join("crates/surface/tests/topography/reference").join(file);
            measured(&Place::new(), &path.display().to_string(), options)
        })
    });
    let made = MADE.iter().enumerate().map(|(number, (name, options, reading))| {
        Case::new(*name, true, move || measured(&synthesized(number, options), "@map.asc", reading))
    });
    let laws = LAWS.iter().map(|(name, made, options)| {
        Case::new(format!("area law, {name}"), !name.contains("windows"), move || {
            let mut record = Record::new();
            synthesized(3, made).run(&format!("area-law @map.asc {options} --json"), &mut record);
            record
        })
    });
    let persson = Case::new("area law, Persson", true, || {
        let mut record = Record::new();
        Place::new().run("area-law --persson-rms-slope 0.0137 --json", &mut record);
        record
    });
    foreign.chain(made).chain(laws).chain([persson]).collect()
}

/// Area laws: name, options of `synthesize`, and options of `area-law`.
const LAWS: [(&str, &str, &str); 7] = [
    ("64 points", "--pixels 64 --waves 4:20", "--windows 0"),
    ("windows", "", "--windows 2"),
    ("another body", "", "--windows 0 --youngs-modulus-gpa 2.5 --poisson-ratio 0.4 --pressures-mpa 0.5,2,8,40"),
    ("threshold", "", "--windows 0 --threshold-mpa 0.3"),
    ("resolutions", "", "--windows 0 --resolutions"),
    ("steep", "--hurst 0.4 --rms-slope 0.05", "--windows 0 --pressures-mpa 0.7,5"),
    ("grooves", "--side-mm 0.5 --cavities 60,60,5", "--windows 0 --pressures-mpa 0.7,5"),
];

/// Folder with the synthetic map map.asc.
fn synthesized(seed: usize, options: &str) -> Place {
    let place = Place::new();
    let size = if options.contains("--pixels") { "" } else { "--pixels 96" };
    let waves = if options.contains("--waves") { "" } else { "--waves 4:32" };
    let (code, _, err) = place.run_raw(&format!("synthesize {size} {waves} --seed {seed} {options} -o @map.asc"));
    assert_eq!(code, 0, "{err}");
    place
}

/// Records the outputs of `surface`.
fn measured(place: &Place, file: &str, options: &str) -> Record {
    let mut record = Record::new();
    place.run(&format!("surface {file} {options} --json -o @out"), &mut record);
    place.record_folder("out", &mut record);
    if fs::exists(place.path("period.asc")).unwrap() {
        place.record_file("period.asc", "period.asc", &mut record);
    }
    record
}
