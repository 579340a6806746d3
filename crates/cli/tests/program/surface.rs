//! `surface`, and `synthesize` with cavities: output, files and refusals.

use crate::common::{Place, at, json};

#[test]
fn a_patterned_map_is_measured_drawn_and_written() {
    let place = Place::with(&[]);
    // Grooves of 130 um, 370 um apart and 5.2 um deep, on 256 pixels of 10 um.
    place.succeed(
        "synthesize --pixels 256 --side-mm 2.56 --waves 4:32 --cavities 130,370,5.2 --wall-um 20 --cavity-std 8,13,0.5 \
         -o textured.asc --quiet",
    );
    assert!(!place.read("textured.asc").contains("one period"));
    let result = place.json("surface textured.asc --cavities --json -o out");
    assert_eq!((&result["format"], &result["synthetic_surface"]), (&"matrix".into(), &true.into()));
    let files = "cavities.csv edge-profile.csv edge-profile.svg histogram.svg map.svg report.html result.json \
                 section.csv section.svg spectrum.csv spectrum.svg";
    assert_eq!(place.listed("out"), files);
    assert_eq!(place.result("out"), result);
    let lines = |name: &str| place.read(name).lines().count();
    assert_eq!((lines("out/section.csv"), lines("out/cavities.csv")), (257, 6));
    assert!(place.read("out/map.svg").len() < 400_000);
    // The same bytes again, and at another number of threads.
    let first = place.untimed("out");
    place.succeed("surface textured.asc --cavities --threads 1 -o out");
    assert!(place.untimed("out") == first);
}

/// Parses the columns of a matrix text, in um.
fn matrix(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|row| row.split('\t').map(|height| height.parse().unwrap()).collect()).collect()
}

#[test]
fn rims_stand_in_the_mean_period() {
    let place = Place::with(&[]);
    place.succeed(
        "synthesize --side-mm 1.024 --waves 4:64 --cavities 60,140,5.2 --wall-um 10 --cavity-std 1,3,0.2 \
         --cavity-shape square --rims 1,16 --rim-profile round --rim-std-um 0.1 -o rims.asc --quiet",
    );
    place.succeed("surface rims.asc --cavities --period-out period.asc");
    // Cavity in the middle, land at 0, rims between.
    let text = place.read("period.asc");
    let period = matrix(&text);
    let (rows, cols) = (period.len(), period[0].len());
    assert_eq!((rows, cols), (100, 100));
    let line = &period[rows / 2];
    assert!((line[cols / 2] + 5.2).abs() < 0.15, "{}", line[cols / 2]);
    // Pixels of 2 um: the wall ends 35 um from the middle, the rim 51 um.
    let mean = |from: usize, to: usize| line[50 + from..50 + to].iter().sum::<f64>() / (to - from) as f64;
    // 1 - s^2 between 1 and 7 um of 16: 0.93
    assert!((mean(18, 21) - 0.93).abs() < 0.15, "{}", mean(18, 21));
    assert!(mean(27, 49).abs() < 0.12, "{}", mean(27, 49));
    let read = place.json("surface period.asc --json");
    let width_um = at(&read, "/pixel_um/0") * rows as f64;
    assert!(read["synthetic_surface"] == true && (width_um - 200.0).abs() < 2.0, "{width_um}");
    // It is replaced as slipgrid's own; the map that it comes from is not.
    place.succeed("surface rims.asc --cavities --period-out period.asc");
    assert_eq!(place.read("period.asc"), text);
    assert!(place.refuse("surface rims.asc --cavities --period-out rims.asc").contains("input of this run"));
}

#[test]
fn a_map_with_one_whole_cavity_has_no_period_and_one_read_in_picometres_is_doubted() {
    let place = Place::with(&[]);
    place.succeed("synthesize --pixels 128 --side-mm 0.4 --waves 2:16 --cavities 100,200,5 -o one.asc");
    let (measured, said) = place.ends("surface one.asc --cavities --period-out period.asc -o out", 2);
    assert!(said.contains("the 1 whole cavities have no mean period: expected at least two"), "{said}");
    // The rest is measured.
    assert!(
        measured.contains("1 cavity takes ")
            && place.listed("out").contains("cavities.csv")
            && !place.listed("").contains("period.asc")
    );
    place.succeed("synthesize --pixels 128 --waves 2:8 --sa-um 0.05 --cavities 130,370,9 -o t.asc");
    for (unit, is_doubted) in [("nm", false), ("pm", true)] {
        let said = place.succeed(&format!("surface t.asc --cavities --height-unit {unit}"));
        assert_eq!(said.contains("! unit of heights: cavities 129 um wide are 8.98 nm deep"), is_doubted, "{said}");
    }
}

#[test]
fn decimal_commas_and_oblong_pixels_are_asked_for_by_flags() {
    let table = "1;2;3;4\n5;6;7;8\n9;10;11;12\n13;14;15;17.5\n";
    let place = Place::with(&[("plain.csv", table), ("comma.csv", &table.replace('.', ","))]);
    let read = |line: &str| place.json(&format!("surface {line} --pixel-um 2 --height-unit nm --form mean --json"));
    let whole = read("plain.csv");
    assert_eq!((at(&whole, "/rows"), at(&whole, "/columns")), (4.0, 4.0));
    assert_eq!(read("comma.csv --decimal-comma")["parameters"], whole["parameters"]);
    assert_eq!(read("plain.csv --pixel-y-um 0.5")["pixel_um"], json("[2.0, 0.5]"));
}

#[test]
fn a_part_of_a_period_is_none_and_keeps_the_slope() {
    let place = Place::with(&[]);
    place.succeed("synthesize --pixels 64 --waves 2:8 --rms-slope 0.02 -o m.asc");
    let says = |flags: &str, what: &str| {
        let law = place.json(&format!("area-law m.asc --pressures-mpa 1 --json {flags}"));
        assert!(law["model"].to_string().contains(what), "{law}");
        [at(&law, "/rows"), at(&law, "/columns"), at(&law, "/pixel_um")]
    };
    let part = says("--crop 0,0,32,64 --form second-order", "surface of second order has been subtracted");
    assert_eq!(part[..2], [32.0, 64.0]);
    says("--crop 0,0,40,64", "the least-squares plane has been subtracted");
    // All but a pixel of a period: its sides continue each other as neighbours do.
    says("--decimate 3", "no plane has been subtracted");
    assert_eq!(says("--decimate 2", "no plane has been subtracted"), [32.0, 32.0, 31.25]);
    // A part keeps the slope of the whole, although its opposite sides do not continue each other.
    place.succeed("synthesize --pixels 256 --side-mm 0.5 -o map.asc");
    let slope = |more: &str| at(&place.json(&format!("surface map.asc --json {more}")), "/parameters/rms_slope");
    let (whole, part) = (slope(""), slope("--crop 0,0,128,128"));
    assert!((part / whole - 1.0).abs() < 0.1, "{part} {whole}");
}
