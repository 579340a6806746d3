//! Tests of pages in real browsers: Chromium, driven over the DevTools protocol, and Firefox, over WebDriver BiDi. A
//! browser that is not installed is skipped:
//! `cargo test --release -p slipgrid-tests --test browser -- --ignored --nocapture`.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod bidi;
mod devtools;
mod pages;
mod studio;
mod wire;

use std::fs;
use std::path::Path;

use bidi::Firefox;
use devtools::Chromium;
use serde_json::{Value, json};

/// A page in a browser.
trait Page {
    /// Evaluates an expression of JavaScript.
    fn ask(&mut self, expression: &str) -> Value;
    /// Presses and releases a key.
    fn press(&mut self, key: &str);
    /// Clicks at a position of the window, in pixels.
    fn click(&mut self, x: f64, y: f64);
    /// Unexpected events of the page: exceptions, console messages, and network requests.
    fn complaints(&self) -> Vec<String>;
}

/// Design that is found in seconds, with a name that is a script unless it is escaped.
fn hostile_design() -> String {
    let (head, _) = include_str!("../golden/inputs/wide-design.toml").split_once("[sample]").unwrap();
    let changes = [
        ("test design", "</script><script>window.hacked = 1</script><b>bold</b>"),
        ("density", "youngs_modulus_std_gpa = 0.08\nwarnings = [\"this material is made up\"]\ndensity"),
        ("dynamic_mean = 0.27", "dynamic_mean = 0.27\ndynamic_std_error = 0.003"),
        ("[1.0, 0.9, 0.7, 0.3]", "[1.0, 0.96, 0.90, 0.60]"),
        ("value = 0.9\ntolerance = 0.01", "value = [0.98, 0.95]\ntolerance = 0.02"),
        ("wavelength_nm = 1064.0", "repetition_hz = 1000.0"),
    ];
    let design = changes.into_iter().fold(head.to_owned(), |design, (from, to)| design.replace(from, to));
    design + "[tolerances]\nwidth_std_um = 4.0\ndepth_std_um = 1.0\n"
}

/// Maximum difference of a sample as cut from one interpolated between textures: only the former has ends, tilt and the
/// change in time computed for its texture.
const AS_CUT: f64 = 0.01;

/// Exit code of the program, and what it wrote.
fn slipgrid(args: &[&str]) -> (u8, String) {
    let (code, out, err) = slipgrid_tests::slipgrid(&[&["--quiet"], args].concat());
    (code, out + &err)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Design and predicted values that the explorer shows.
fn shown(page: &mut dyn Page) -> ([f64; 3], Vec<f64>) {
    let lengths = page.ask("[...document.querySelectorAll('[data-number]')].map(field => parseFloat(field.value))");
    let values = page.ask("JSON.parse(document.getElementById('explorer').dataset.values)");
    let numbers = |of: &Value| -> Vec<f64> { of.as_array().unwrap().iter().map(number).collect() };
    (numbers(&lengths).try_into().unwrap(), numbers(&values))
}

/// Predicted medians for each of `designs` by the model itself, from `next`.
fn predicted(folder: &Path, designs: &[[f64; 3]]) -> Vec<Vec<f64>> {
    let named = designs.iter().map(|lengths| format!("--candidate={}", lengths.map(|um| um.to_string()).join(",")));
    let design = folder.join("design-task.toml").to_str().unwrap().to_owned();
    let args: Vec<String> = ["next".to_owned(), design, "--json".to_owned()].into_iter().chain(named).collect();
    let (code, told) = slipgrid(&args.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(code, 0, "{told}");
    let found: Value = serde_json::from_str(&told).unwrap();
    let medians =
        |of: &Value| of["expected"].as_array().unwrap().iter().map(|at| number(&at["median"])).collect::<Vec<f64>>();
    found["own"].as_array().unwrap().iter().map(medians).collect()
}

#[test]
#[ignore = "needs Chromium or Firefox; a minute"]
fn the_explorer_says_what_is_predicted_and_needs_no_mouse() {
    let folder = tempfile::tempdir().unwrap();
    let (design, out) = (folder.path().join("design-task.toml"), folder.path().join("out"));
    fs::write(&design, hostile_design()).unwrap();
    let (code, told) = slipgrid(&["optimize", design.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    assert_eq!(code, 0, "{told}");
    let report = out.join("report.html");
    let firefox = Firefox::open(&report);
    let chromium = Chromium::open(&report);
    if firefox.is_none() && chromium.is_none() {
        println!("skipped: neither Chromium nor Firefox");
    }
    if let Some(mut page) = firefox {
        println!("Firefox:");
        explores(&mut page, folder.path());
    }
    let Some(mut page) = chromium else { return };
    println!("Chromium:");
    explores(&mut page, folder.path());
    assert!(page.prints_all("#doubts li") && page.prints_all(".odds svg"));
    let printed = page.printed_pages();
    println!("{printed} printed pages");
    assert!(printed <= 4, "{printed}");
    assert!(fs::metadata(&report).unwrap().len() <= 400_000);
    page.ask("document.querySelectorAll('details').forEach(own => { own.open = true; })");
    for window in pages::WINDOWS {
        page.resize(window);
        assert_eq!(page.ask(pages::CUT_OFF), json!([]), "{window:?}");
        assert_eq!(page.ask(pages::SMALL_TEXT), json!([]), "{window:?}");
        for scheme in ["light", "dark"] {
            page.scheme(scheme);
            assert_eq!(page.ask(pages::CONTRAST), json!([]), "{scheme} {window:?}");
        }
    }
}

/// Uses the explorer of out/report.html in `folder` as a reader does, and checks its values.
fn explores(page: &mut dyn Page, folder: &Path) {
    let out = folder.join("out");
    // The stated error.
    let words = page.ask("document.querySelector('.screen p').textContent");
    let stated: Vec<f64> = words
        .as_str()
        .unwrap()
        .split_whitespace()
        .filter_map(|word| word.trim_end_matches([',', '.']).parse().ok())
        .collect();
    let [_, median, worst] = stated[..] else { panic!("{words}") };
    println!("{}", words.as_str().unwrap());
    assert!(median < 0.001 && worst < 0.03, "{words}");

    // It begins with the design found, and with what is expected of that.
    let result: Value = serde_json::from_str(&fs::read_to_string(out.join("result.json")).unwrap()).unwrap();
    let (start, first) = shown(page);
    for (value, at) in first.iter().zip(result["expected"].as_array().unwrap()) {
        assert!((value - number(&at["median"])).abs() <= worst + AS_CUT, "{value} {at}");
    }
    let chance = number(&page.ask("parseFloat(document.getElementById('explorer').dataset.chance)"));
    assert!((chance - number(&result["chance"])).abs() < 0.1, "{chance} {}", result["chance"]);

    // Friction and pressure are those of the confirming run, at the last pressure.
    let confirmed = result["confirmed"].as_array().unwrap();
    let last = |name: &str| number(&confirmed.last().unwrap()[name]);
    let said = |page: &mut dyn Page, name: &str| {
        let text = page.ask(&format!("document.querySelector('[data-{name}]').textContent"));
        text.as_str().unwrap().parse::<f64>().unwrap()
    };
    let (mu, peak) = (said(page, "second"), said(page, "peak"));
    let expected = first.last().unwrap() * last("mu_flat");
    assert!((mu - expected).abs() < 6e-4, "{mu} {expected}");
    let largest = confirmed.iter().map(|load| number(&load["peak_pressure_mpa"])).fold(0.0, f64::max);
    assert!((peak - largest).abs() < 0.06, "{peak} {largest}");
    // Sliders say their values with units, and both axes of the map have ticks.
    let values =
        page.ask("[...document.querySelectorAll('input[type=range]')].map(own => own.getAttribute('aria-valuetext'))");
    let values: Vec<&str> = values.as_array().unwrap().iter().map(|own| own.as_str().unwrap()).collect();
    assert!(values[..3].iter().all(|own| own.ends_with(" µm")) && values[3].ends_with(" MPa"), "{values:?}");
    let ticks = page.ask("[...document.querySelectorAll('.ticks')].map(own => own.children.length)");
    assert!(ticks.as_array().unwrap().iter().all(|count| number(count) >= 2.0), "{ticks}");

    // Sliders move by the keyboard, and the curve with them; deeper, as shallow cavities close under load.
    let (mut last, mut seen) = (start, Vec::new());
    for (axis, key, times) in [(0, "ArrowRight", 60), (1, "ArrowLeft", 90), (2, "ArrowRight", 120)] {
        page.ask(&format!("document.querySelector('[data-slider=\"{axis}\"]').focus()"));
        for _ in 0..times {
            page.press(key);
        }
        let (lengths, values) = shown(page);
        assert!(lengths[axis] != last[axis] && lengths[(axis + 1) % 3] == last[(axis + 1) % 3], "{lengths:?}");
        last = lengths;
        seen.push((lengths, values));
    }
    let designs: Vec<[f64; 3]> = seen.iter().map(|(lengths, _)| *lengths).collect();
    for ((lengths, values), medians) in seen.iter().zip(predicted(folder, &designs)) {
        for (value, median) in values.iter().zip(medians) {
            assert!((value - median).abs() <= worst + AS_CUT, "{lengths:?}: {value} {median}");
        }
    }
    // Numbers that are typed, also beyond the bounds.
    page.ask("(() => { const field = document.querySelector('[data-number=\"0\"]'); field.value = '1e9'; field.dispatchEvent(new Event('change')); })()");
    assert_eq!(shown(page).0[0], 400.0);
    let took = page.ask(
        "(() => { const slider = document.querySelector('[data-slider=\"2\"]'), took = []; for (let k = 0; k < 50; k++) { slider.value = 300 + 8 * k; \
         const start = performance.now(); slider.dispatchEvent(new Event('input')); took.push(performance.now() - start); } \
         took.sort((a, b) => a - b); return [took[5], took[25], took[49]]; })()",
    );
    println!("a step of a slider takes {took} ms (fastest tenth, median, longest)");

    // The map chooses by a click; the copied scene is accepted.
    page.ask("document.querySelector('[data-map]').scrollIntoView({ block: 'center' })");
    let middle = page.ask("(() => { const box = document.querySelector('[data-map]').getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; })()");
    page.click(number(&middle[0]), number(&middle[1]));
    let (lengths, _) = shown(page);
    assert!((lengths[0] / (40.0_f64 * 400.0).sqrt() - 1.0).abs() < 0.03, "{lengths:?}");
    page.ask("document.querySelector('[data-copy]').focus()");
    page.press("Enter");
    // Keys press buttons of a window that has the focus alone: headless Firefox gives it none.
    if page.ask("document.hasFocus()") == json!(false) {
        page.ask("document.querySelector('[data-copy]').click()");
    }
    let copied = page.ask("document.querySelector('[data-toml]').value");
    let scene = folder.join("copied.toml");
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

    assert_eq!(page.ask("window.hacked === undefined && document.querySelector('h1 b') === null"), json!(true));
    assert_eq!(page.complaints(), Vec::<String>::new());
}
