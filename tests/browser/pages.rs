//! Tests of every page on a desktop and on a phone, in the light and in the dark colour scheme.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use slipgrid_laser::export::{Outline, Specimen};
use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Texture};

use super::devtools::Chromium;
use super::{Page, slipgrid};

/// Sizes of the windows of a desktop and of a phone, in pixels.
pub const WINDOWS: [[u32; 2]; 2] = [[1280, 800], [390, 844]];

/// Calibration with one trial of grooves, which is learned in a second.
const CALIBRATION: &str = r#"name = "<i>polymer</i>"
source = "nobody measured it"
[material]
youngs_modulus_gpa = 0.38
youngs_modulus_std_gpa = 0.08
density_g_cm3 = 0.9
[surface]
persson_rms_slope = 0.0137
[specimen]
radius_mm = 5.0
[measurements]
flat = "flat.csv"
[[trial]]
name = "cut & measured"
date = "2026-11-22"
pattern = { planform = "groove", width_um = 120.0, spacing_um = 660.0, depth_um = 10.4 }
measurements = "cut.csv"
[[trial]]
name = "squares"
pattern = { planform = "square", width_um = 130.0, spacing_um = 370.0, depth_um = 5.2 }
measurements = "cut.csv"
"#;
const HEADER: &str = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n";
const DESIGN: &str = r#"name = "grooves"
material = "material.toml"
condition = { speed_mm_s = 2.0, humidity_pct = 40.0 }
[target]
quantity = "ratio"
pressure_mpa = [0.6366, 2.5465]
value = [0.87, 0.80]
tolerance = 0.01
[bounds]
width_um = [40.0, 200.0]
spacing_um = [40.0, 1000.0]
depth_um = [5.0, 20.0]
[specimen]
shape = "disc"
diameter_mm = 10.0
"#;

fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn run(args: &[&str]) {
    let (code, told) = slipgrid(args);
    assert_eq!(code, 0, "{args:?}: {told}");
}

#[test]
#[ignore = "needs Chromium; a minute"]
fn pages_can_be_read_on_a_desk_and_on_a_phone() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let calibration = file(folder.path(), "calibration.toml", CALIBRATION);
    file(
        folder.path(),
        "flat.csv",
        &format!("{HEADER}50,2,40,0.2480,0.001\n100,2,40,0.2620,0.001\n200,2,40,0.2700,0.001\n"),
    );
    file(
        folder.path(),
        "cut.csv",
        &format!("{HEADER}50,2,40,0.2344,0.001\n100,2,40,0.2452,0.001\n200,2,40,0.2465,0.001\n"),
    );
    run(&["calibrate", &calibration, "-o", &at("material.toml"), "--report", &at("fit")]);
    run(&["trials", &calibration, "-o", &at("trials")]);
    run(&["surface", &grooved_map(folder.path()), "--cavities", "-o", &at("surface")]);
    let design = file(folder.path(), "design.toml", DESIGN);
    run(&["explore", &design, "-o", &at("explore.html")]);
    for name in ["fit/report.html", "trials/report.html", "surface/report.html", "explore.html"] {
        let Some(mut page) = Chromium::open(&folder.path().join(name)) else {
            println!("skipped: no Chromium");
            return;
        };
        page.ask("document.querySelectorAll('details').forEach(own => { own.open = true; })");
        assert_eq!(page.ask(SKIPPED_LEVELS), json!([]), "{name}");
        for window in WINDOWS {
            page.resize(window);
            assert_eq!(page.ask(CUT_OFF), json!([]), "{name} {window:?}");
            assert_eq!(page.ask(SMALL_TEXT), json!([]), "{name} {window:?}");
            for scheme in ["light", "dark"] {
                page.scheme(scheme);
                assert_eq!(page.ask(CONTRAST), json!([]), "{name} {scheme}");
            }
        }
        assert_eq!(page.ask("document.querySelector('i') === null"), json!(true), "{name}");
        assert_eq!(page.complaints(), Vec::<String>::new(), "{name}");
        if name == "explore.html" {
            trials_are_points(&mut page);
        }
    }
}

/// For wide and shallow cavities of a soft material, which close, the page gives no numbers but says so.
#[test]
#[ignore = "needs Chromium"]
fn cavities_that_close_have_no_answer() {
    let folder = tempfile::tempdir().unwrap();
    let material = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\nstatic_mean = 0.30\ndynamic_mean = 0.27\n\
                    [area_law]\npressure_mpa = [0.7, 1.3, 2.6, 10.0]\nfactor = [1.0, 0.96, 0.90, 0.60]\n";
    let material = file(folder.path(), "material.toml", material);
    let path = folder.path().join("explore.html");
    run(&["explore", &material, "-o", path.to_str().unwrap()]);
    let Some(mut page) = Chromium::open(&path) else {
        println!("skipped: no Chromium");
        return;
    };
    let mut at = |lengths: [f64; 3]| {
        page.ask(&typed(lengths));
        let of = |name: &str| format!("document.querySelector('[data-{name}]').textContent");
        ["verdict", "first", "second", "closed-words"].map(|name| page.ask(&of(name)).as_str().unwrap().to_owned())
    };
    let [verdict, first, second, map] = at([300.0, 100.0, 2.0]);
    assert!(verdict.contains("no answer"), "{verdict}");
    assert_eq!((first.as_str(), second.as_str()), ("-", "-"));
    assert!(map.contains("Blank: ") && map.contains("no answer"), "{map}");
    let [verdict, first, second, _] = at([60.0, 300.0, 20.0]);
    let [ratio, mu] = [first, second].map(|own| own.parse::<f64>().unwrap());
    assert!(verdict.is_empty() && ratio > 0.8 && (mu / ratio / 0.243 - 1.0).abs() < 4e-3, "{verdict} {ratio} {mu}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// The page counts the cavities that fit on a specimen as the layout does, for every planform and outline.
#[test]
#[ignore = "needs Chromium"]
fn a_page_shows_the_areal_density_of_the_layout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("explore.html");
    let disc = "shape = \"disc\"\ndiameter_mm = 2.0\n";
    let ring = "shape = \"ring\"\nouter_diameter_mm = 4.0\ninner_diameter_mm = 1.7\n";
    let plate = "shape = \"rectangle\"\nlength_mm = 3.1\nwidth_mm = 2.3\n";
    let [disc_of, ring_of, plate_of] = [
        Outline::Disc { diameter_m: 2e-3 },
        Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.7e-3 },
        Outline::Rectangle { length_m: 3.1e-3, width_m: 2.3e-3 },
    ];
    let texture = Texture::new;
    let hexagonal = texture(Planform::Disc).with_arrangement(Arrangement::Hexagonal).unwrap();
    let staggered = texture(Planform::Square).with_arrangement(Arrangement::Staggered).unwrap();
    for (specimen, outline, planform, texture) in [
        (disc, disc_of, "groove\"", texture(Planform::Groove)),
        (ring, ring_of, "groove\"", texture(Planform::Groove)),
        (plate, plate_of, "groove\"\nangle_deg = 90.0", texture(Planform::Groove).with_groove_angle_deg(90.0).unwrap()),
        (ring, ring_of, "square\"\narrangement = \"staggered\"", staggered),
        (plate, plate_of, "square\"", texture(Planform::Square)),
        (disc, disc_of, "disc\"\narrangement = \"hexagonal\"", hexagonal),
        (ring, ring_of, "disc\"", texture(Planform::Disc)),
    ] {
        let design = super::hostile_design()
            .split("[pattern]")
            .next()
            .unwrap()
            .replace("spacing_um = [40.0, 1000.0]", "spacing_um = [60.0, 400.0]");
        let design = format!(
            "{design}[pattern]\nplanform = \"{planform}\n[specimen]\n{specimen}[sample]\nlayer_um = 80\nblock_um = 20\n"
        );
        run(&["explore", &file(folder.path(), "design.toml", &design), "-o", path.to_str().unwrap()]);
        let Some(mut page) = Chromium::open(&path) else {
            println!("skipped: no Chromium");
            return;
        };
        for lengths in [[101.3, 98.7, 10.0], [63.0, 217.3, 10.0], [208.1, 371.9, 10.0], [85.6, 71.2, 10.0]] {
            page.ask(&typed(lengths));
            let shown = page.ask("document.querySelector('[data-density]').textContent");
            let [width_m, spacing_m, depth_m] = lengths.map(|um: f64| 1e-6 * um);
            let pattern = Pattern::new(texture, width_m, spacing_m, depth_m).unwrap();
            let layout = Specimen { outline, is_clipped: false }.layout(pattern).unwrap();
            assert_eq!(shown, json!(format!("{:.1}", 100.0 * layout.areal_density())), "{planform} {lengths:?}");
        }
        assert_eq!(page.complaints(), Vec::<String>::new());
    }
}

/// Script that types `lengths` into the fields of the explorer.
fn typed(lengths: [f64; 3]) -> String {
    let one = |(place, length): (usize, f64)| {
        format!(
            "(() => {{ const own = document.querySelector('[data-number=\"{place}\"]'); own.value = {length}; \
             own.dispatchEvent(new Event('change')); }})();"
        )
    };
    lengths.into_iter().enumerate().map(one).collect()
}

/// A cell of the map is hatched if and only if the design chosen by a click on it violates a limit.
#[test]
#[ignore = "needs Chromium"]
fn designs_that_break_the_limit_of_laser_time_are_hatched() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("explore.html");
    // Most designs violate the limit of laser time, and none another one.
    let limited = super::hostile_design()
        .replace("min_land_um = 40.0", "max_laser_time_s = 150.0")
        .replace("max_peak_pressure_mpa = 20.0\n", "");
    run(&["explore", &file(folder.path(), "design.toml", &limited), "-o", path.to_str().unwrap()]);
    let Some(mut page) = Chromium::open(&path) else {
        println!("skipped: no Chromium");
        return;
    };
    // So deep that it takes a part of the textures too long.
    page.ask(
        "(() => { const own = document.querySelector('[data-number=\"2\"]'); own.value = 8; own.dispatchEvent(new Event('change')); })()",
    );
    let found = page.ask(HATCHED);
    println!("{found}");
    let count = |name: &str| found[name].as_u64().unwrap();
    assert_eq!(found["wrong"], json!([]));
    assert!(count("hatched") > 100 && count("hatched") + 100 < count("cells"), "{found}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Script that compares every third cell of the map with the verdict for its middle; skips cells next to different ones
/// and cells with a point.
const HATCHED: &str = r"(() => {
  const map = document.querySelector('[data-map]'), verdict = document.querySelector('[data-verdict]'), side = 4;
  const [columns, rows] = [map.width / side, map.height / side];
  const { data } = map.getContext('2d').getImageData(0, 0, map.width, map.height);
  const colours = (column, row) => {
    const found = new Set();
    for (let y = row * side; y < (row + 1) * side; y++) for (let x = column * side; x < (column + 1) * side; x++) found.add(data.slice(4 * (y * map.width + x), 4 * (y * map.width + x) + 3).join());
    return found.size;
  };
  const isHatched = (column, row) => colours(column, row) > 1;
  const box = map.getBoundingClientRect(), wrong = [];
  let cells = 0, hatched = 0;
  for (let row = 1; row < rows - 1; row += 3) for (let column = 1; column < columns - 1; column += 3) {
    const own = isHatched(column, row), near = [[-1, 0], [1, 0], [0, -1], [0, 1]];
    if (near.some(([x, y]) => isHatched(column + x, row + y) !== own) || colours(column, row) > 2) continue;
    map.dispatchEvent(new MouseEvent('click', { clientX: box.left + box.width * (column + 0.5) / columns, clientY: box.top + box.height * (row + 0.5) / rows }));
    cells++;
    hatched += own;
    const isBroken = verdict.textContent.includes('breaks');
    if (isBroken !== own) wrong.push([column, row, verdict.textContent]);
  }
  return { cells, hatched, wrong };
})()";

/// The trial of grooves is on the map and can be chosen; the trial of squares is only in the list.
fn trials_are_points(page: &mut Chromium) {
    let points = page.ask("JSON.parse(document.getElementById('explorer-data').textContent).points");
    let on_map: Vec<&Value> = points.as_array().unwrap().iter().map(|point| &point["on_map"]).collect();
    assert_eq!(on_map, [&json!(true), &json!(false)]);
    page.ask("document.querySelector('[data-go]').click()");
    let lengths = page.ask("[...document.querySelectorAll('[data-number]')].map(field => parseFloat(field.value))");
    let lengths: Vec<f64> = lengths.as_array().unwrap().iter().map(super::number).collect();
    assert_eq!(lengths, [120.0, 660.0, 10.4]);
    let listed = page.ask("[...document.querySelectorAll('.points tbody tr')].map(row => row.textContent)");
    let listed: Vec<&str> = listed.as_array().unwrap().iter().map(|row| row.as_str().unwrap()).collect();
    // The ratio that was measured, beside what is expected there of another sample.
    let shown = page.ask("JSON.parse(document.getElementById('explorer').dataset.values)[0]").as_f64().unwrap();
    assert!(listed[0].contains(&format!("0.945 at 0.64 MPa (expected {shown:.3})")), "{listed:?} {shown}");
    assert!(listed[1].contains("squares (another texture)") && listed[1].contains("(modelled 0.9"), "{listed:?}");
}

/// Map of five grooves on a rough surface, as a matrix of heights.
fn grooved_map(folder: &Path) -> String {
    const SIDE: usize = 200;
    const PITCH: usize = 40;
    let mut text = "# Width: 0.4 mm\n# Height: 0.4 mm\n# Value units: m\n".to_owned();
    for row in 0..SIDE {
        let heights = (0..SIDE).map(|column| {
            let roughness = 0.05 * ((row * 7 + column * 13) as f64 * 0.7).sin();
            let depth = if column % PITCH < 12 { -5.0 } else { 0.0 };
            format!("{:.3e}", (roughness + depth) * 1e-6)
        });
        text += &(heights.collect::<Vec<_>>().join("\t") + "\n");
    }
    file(folder, "grooves.asc", &text)
}

/// Script that lists elements beyond the window that cannot be scrolled to within their own frame.
pub const CUT_OFF: &str = r"(() => {
  const cut = [], width = document.documentElement.clientWidth;
  for (const element of document.querySelectorAll('body *')) {
    if (element.closest('svg') && element.tagName !== 'svg') continue;
    const box = element.getBoundingClientRect();
    if (!box.width || box.right <= width + 1 && box.left >= -1) continue;
    let scrolls = false;
    for (let own = element.parentElement; own && !scrolls; own = own.parentElement) scrolls = getComputedStyle(own).overflowX === 'auto';
    if (!scrolls) cut.push(`${element.tagName} ${element.className} ${box.left.toFixed(0)} to ${box.right.toFixed(0)} ${element.textContent.slice(0, 30)}`);
  }
  return cut;
})()";

/// Script that lists headings more than one level below the heading before.
pub const SKIPPED_LEVELS: &str = r"(() => {
  const headings = [...document.querySelectorAll('h1, h2, h3, h4')], level = heading => Number(heading?.tagName[1] ?? 0);
  return headings.filter((own, i) => level(own) > level(headings[i - 1]) + 1).map(own => `${own.tagName} ${own.textContent}`);
})()";

/// Script that lists text in drawings of less than 9 pixels on the screen.
pub const SMALL_TEXT: &str = r"(() => {
  const small = [];
  for (const text of document.querySelectorAll('svg text')) {
    if (!text.getClientRects().length) continue;
    const turn = text.getScreenCTM(), size = parseFloat(getComputedStyle(text).fontSize) * Math.hypot(turn.a, turn.b);
    if (size < 8.95) small.push(`${size.toFixed(1)} ${text.textContent}`);
  }
  return small.slice(0, 5);
})()";

/// Script that lists text with a lower contrast to its background than WCAG 2.2 AA requires: 4.5, or 3 for large text.
pub const CONTRAST: &str = r"(() => {
  const parse = colour => { const found = colour.match(/[\d.]+/g).map(Number); return [found.slice(0, 3), found[3] ?? 1]; };
  const luminance = rgb => { const [r, g, b] = rgb.map(v => { v /= 255; return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const behind = element => { for (let own = element; own; own = own.parentElement) { const [rgb, alpha] = parse(getComputedStyle(own).backgroundColor); if (alpha > 0.5) return rgb; } return parse(getComputedStyle(document.body).backgroundColor)[0]; };
  const poor = [];
  for (const element of document.querySelectorAll('body *')) {
    const drawn = element.tagName === 'text';
    if (element.closest('svg') && !drawn || !element.getClientRects().length) continue;
    if (![...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim())) continue;
    const style = getComputedStyle(element), size = parseFloat(style.fontSize), large = !drawn && (size >= 24 || (size >= 18.66 && +style.fontWeight >= 700));
    const [a, b] = [luminance(parse(drawn ? style.fill : style.color)[0]), luminance(behind(element))], ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < (large ? 3 : 4.5)) poor.push(`${element.tagName} ${element.className} ${ratio.toFixed(2)} ${element.textContent.slice(0, 40)}`);
  }
  return poor;
})()";
