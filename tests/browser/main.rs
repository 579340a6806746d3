//! The pages in a real browser, driven over the DevTools protocol. Run where Chromium is found:
//! `cargo test --release -p slipgrid-tests --test browser -- --ignored --nocapture`.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod devtools;

use std::fs;
use std::path::Path;

use devtools::Page;
use serde_json::{Value, json};

/// A design that is found in seconds, with a name that would be a script if it could.
const DESIGN: &str = r#"name = "</script><script>window.hacked = 1</script><b>bold</b>"
[material]
youngs_modulus_gpa = 0.38
youngs_modulus_std_gpa = 0.08
density_g_cm3 = 0.9
[material.friction]
static_mean = 0.30
dynamic_mean = 0.27
dynamic_std_error = 0.003
[material.area_law]
pressure_mpa = [0.7, 1.3, 2.6, 10.0]
factor = [1.0, 0.96, 0.90, 0.60]
[target]
quantity = "ratio"
pressure_mpa = [0.65, 2.6]
value = [0.98, 0.95]
tolerance = 0.02
[bounds]
width_um = [40.0, 400.0]
spacing_um = [40.0, 1000.0]
depth_um = [2.0, 50.0]
[pattern]
planform = "groove"
[limits]
min_land_um = 40.0
depth_per_burst_um = 2.6
max_peak_pressure_mpa = 20.0
[laser]
spot_um = 23.0
repetition_hz = 1000.0
[specimen]
shape = "disc"
diameter_mm = 10.0
[tolerances]
width_std_um = 4.0
depth_std_um = 1.0
[search]
max_evaluations = 200
"#;

fn slipgrid(args: &[&str]) -> (u8, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = slipgrid_cli::run([&["slipgrid", "--quiet"], args].concat(), &mut out, &mut err);
    (code, String::from_utf8(out).unwrap() + &String::from_utf8(err).unwrap())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// What the page shows: the design, and its values less what corrects them.
fn shown(page: &mut Page) -> ([f64; 3], Vec<f64>) {
    let lengths = page.ask("[...document.querySelectorAll('[data-number]')].map(field => parseFloat(field.value))");
    let values = page.ask("JSON.parse(document.getElementById('explorer').dataset.values)");
    let offset = page.ask("JSON.parse(document.getElementById('explorer-data').textContent).offset");
    let values = values.as_array().unwrap().iter().zip(offset.as_array().unwrap());
    let lengths: Vec<f64> = lengths.as_array().unwrap().iter().map(number).collect();
    (lengths.try_into().unwrap(), values.map(|(value, offset)| number(value) - number(offset)).collect())
}

/// Ratios that `simulate` finds for an endless pattern of the material of design.toml.
fn simulated(folder: &Path, [width_um, spacing_um, depth_um]: [f64; 3]) -> Vec<f64> {
    let mut scene: toml::Table = fs::read_to_string(folder.join("design.toml")).unwrap().parse().unwrap();
    scene.remove("specimen");
    let pattern = scene["pattern"].as_table_mut().unwrap();
    for (key, length_um) in [("width_um", width_um), ("spacing_um", spacing_um), ("depth_um", depth_um)] {
        pattern.insert(key.to_owned(), length_um.into());
    }
    let path = folder.join("endless.toml");
    fs::write(&path, toml::to_string(&scene).unwrap()).unwrap();
    let flags = ["--fidelity", "steady", "--extent", "cell", "--json"];
    let (code, told) = slipgrid(&[&["simulate", path.to_str().unwrap()][..], &flags].concat());
    assert_eq!(code, 0, "{told}");
    let found: Value = serde_json::from_str(&told).unwrap();
    found["results"].as_array().unwrap().iter().map(|load| number(&load["ratio"])).collect()
}

#[test]
#[ignore = "needs Chromium; half a minute"]
fn the_explorer_says_what_the_solver_does_and_needs_no_mouse() {
    let folder = tempfile::tempdir().unwrap();
    let (design, out) = (folder.path().join("design-task.toml"), folder.path().join("out"));
    fs::write(&design, DESIGN).unwrap();
    let (code, told) = slipgrid(&["optimize", design.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    assert_eq!(code, 0, "{told}");
    let Some(mut page) = Page::open(&out.join("report.html")) else {
        println!("skipped: no Chromium");
        return;
    };

    // The stated error.
    let words = page.ask("document.querySelector('.screen p').textContent");
    let stated: Vec<f64> = words.as_str().unwrap().split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let (median, worst) = (stated[0], stated[1]);
    println!("{}", words.as_str().unwrap());
    // Where blocks are cut in part the solver itself has steps of some thousandths, which no smooth surface follows.
    assert!(median < 0.001 && worst < 0.005, "{words}");

    // Sliders move by the keyboard, and the curve with them.
    let (start, _) = shown(&mut page);
    let mut last = start;
    for (axis, key, times) in [(0, "ArrowRight", 60), (1, "ArrowLeft", 90), (2, "ArrowLeft", 120)] {
        page.ask(&format!("document.querySelector('[data-slider=\"{axis}\"]').focus()"));
        for _ in 0..times {
            page.press(key);
        }
        let (lengths, values) = shown(&mut page);
        assert!(lengths[axis] != last[axis] && lengths[(axis + 1) % 3] == last[(axis + 1) % 3], "{lengths:?}");
        last = lengths;
        for (value, exact) in values.iter().zip(simulated(&out, lengths)) {
            assert!((value - exact).abs() <= worst, "{lengths:?}: {value} {exact}");
        }
    }
    // Numbers that are typed, also beyond the bounds.
    page.ask("(() => { const field = document.querySelector('[data-number=\"0\"]'); field.value = '1e9'; field.dispatchEvent(new Event('change')); })()");
    assert_eq!(shown(&mut page).0[0], 400.0);
    let took = page.ask(
        "(() => { const slider = document.querySelector('[data-slider=\"2\"]'), took = []; for (let k = 0; k < 50; k++) { slider.value = 300 + 8 * k; \
         const start = performance.now(); slider.dispatchEvent(new Event('input')); took.push(performance.now() - start); } \
         took.sort((a, b) => a - b); return [took[25], took[49]]; })()",
    );
    println!("a step of a slider takes {took} ms (median, longest)");

    // The map chooses by a click; the copied scene is accepted.
    page.ask("document.querySelector('[data-map]').scrollIntoView({ block: 'center' })");
    let middle = page.ask("(() => { const box = document.querySelector('[data-map]').getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; })()");
    page.click(number(&middle[0]), number(&middle[1]));
    let (lengths, _) = shown(&mut page);
    assert!((lengths[0] / (40.0_f64 * 400.0).sqrt() - 1.0).abs() < 0.03, "{lengths:?}");
    page.ask("document.querySelector('[data-copy]').focus()");
    page.press("Enter");
    let copied = page.ask("document.querySelector('[data-toml]').value");
    let scene = folder.path().join("copied.toml");
    fs::write(&scene, copied.as_str().unwrap()).unwrap();
    let written: toml::Table = copied.as_str().unwrap().parse().unwrap();
    assert_eq!(written["pattern"]["width_um"].as_float().unwrap(), lengths[0]);
    let (code, told) =
        slipgrid(&["simulate", scene.to_str().unwrap(), "--fidelity", "steady", "--extent", "cell", "--json"]);
    assert_eq!(code, 0, "{told}");

    // Everything can be reached by Tab alone.
    let reached = page.ask(
        "(() => { const wanted = [...document.querySelectorAll('#explorer input, #explorer button, #explorer select')]; \
         return wanted.every(own => own.tabIndex >= 0 && !own.disabled); })()",
    );
    assert_eq!(reached, json!(true));

    for scheme in ["light", "dark"] {
        page.scheme(scheme);
        let poor = page.ask(CONTRAST);
        assert_eq!(poor, json!([]), "{scheme}");
    }
    assert_eq!(page.ask("window.hacked === undefined && document.querySelector('h1 b') === null"), json!(true));
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Text whose contrast with what lies behind it is less than WCAG 2.2 AA asks for: 4.5, of large text 3.
const CONTRAST: &str = r"(() => {
  const parse = colour => { const found = colour.match(/[\d.]+/g).map(Number); return [found.slice(0, 3), found[3] ?? 1]; };
  const luminance = rgb => { const [r, g, b] = rgb.map(v => { v /= 255; return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const behind = element => { for (let own = element; own; own = own.parentElement) { const [rgb, alpha] = parse(getComputedStyle(own).backgroundColor); if (alpha > 0.5) return rgb; } return parse(getComputedStyle(document.body).backgroundColor)[0]; };
  const poor = [];
  for (const element of document.querySelectorAll('body *')) {
    if (element.closest('svg') || !element.getClientRects().length) continue;
    if (![...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim())) continue;
    const style = getComputedStyle(element), size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && +style.fontWeight >= 700);
    const [a, b] = [luminance(parse(style.color)[0]), luminance(behind(element))], ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < (large ? 3 : 4.5)) poor.push(`${element.tagName} ${element.className} ${ratio.toFixed(2)} ${element.textContent.slice(0, 40)}`);
  }
  return poor;
})()";
