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
