//! The studio as a laboratory uses it, in each browser that is found: from raw files to a laser file, a trial, and the next one.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;

use super::bidi::Firefox;
use super::devtools::Chromium;
use super::{Page, pages};

/// Longest wait for anything on the page.
const PATIENCE: Duration = Duration::from_secs(120);
/// Raw traces, one of each load, of a laboratory that does not exist.
const TRACES: [&str; 5] = ["flat-30N-1.csv", "flat-80N-1.csv", "flat-160N-1.csv", "flat-300N-1.csv", "flat-300N-2.csv"];
/// Script that acts on the page: finds an element by its name, clicks, types, drops files. Requests and answers are
/// late by up to 400 ms and overtake one another, as on a busy computer.
const HAND: &str = r"(() => {
const ask = window.fetch.bind(window);
let state = 1;
const late = () => { state = 48271 * state % 2147483647; return new Promise(go => setTimeout(go, 400 * (state / 2147483647) ** 3)); };
window.fetch = async (...asked) => { await late(); const answer = await ask(...asked); await late(); return answer; };
window.named = (selector, name) => [...document.querySelectorAll(selector)].find(own => own.getClientRects().length > 0
  && (own.getAttribute('aria-label') ?? (own.labels?.length ? own.labels[0].textContent : own.textContent)).trim().startsWith(name));
window.press = (name, selector = 'button, a, summary') => { const own = named(selector, name); own?.click(); return Boolean(own); };
window.enter = (name, text) => { const own = named('input, select', name); if (!own) return false; own.value = text;
  own.dispatchEvent(new Event('input', { bubbles: true })); own.dispatchEvent(new Event('change', { bubbles: true })); return true; };
window.drop = (selector, files) => { const zone = document.querySelector(selector); if (!zone) return false; const data = new DataTransfer();
  files.forEach(([name, text]) => data.items.add(new File([text], name)));
  zone.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true })); return true; };
window.says = (text) => document.body.textContent.includes(text);
return true; })()";

/// The program beside the tests.
fn program() -> Command {
    let release = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().join("release");
    Command::new(release.join(format!("slipgrid{}", std::env::consts::EXE_SUFFIX)))
}

/// A studio that works in a folder.
struct Studio {
    child: Child,
    address: String,
}

impl Studio {
    fn start(folder: &Path) -> Self {
        let mut studio = program();
        studio.args(["studio", "--no-browser"]).arg(folder).stdout(Stdio::piped());
        let mut child = studio.spawn().expect("the program: cargo build --release");
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().rsplit_once(' ').unwrap().1.to_owned();
        Self { child, address }
    }

    fn own(&self) -> &str {
        self.address.split("?token").next().unwrap()
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Waits until `expression` is true.
fn wait(page: &mut dyn Page, expression: &str) {
    let until = Instant::now() + PATIENCE;
    while page.ask(expression) != json!(true) {
        if Instant::now() > until {
            panic!("{expression}: {}", page_text(page));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Waits until `is_so` returns true.
fn until(is_so: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < end);
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn page_text(page: &mut dyn Page) -> String {
    page.ask("document.body.innerText").to_string()
}

fn press(page: &mut dyn Page, name: &str) {
    wait(page, &format!("press({})", json!(name)));
}

fn enter(page: &mut dyn Page, name: &str, text: &str) {
    wait(page, &format!("enter({}, {})", json!(name), json!(text)));
}

fn says(page: &mut dyn Page, text: &str) {
    wait(page, &format!("says({})", json!(text)));
}

fn drop_files(page: &mut dyn Page, zone: &str, files: &[(String, String)]) {
    wait(page, &format!("drop({}, {})", json!(zone), json!(files)));
}

#[test]
#[ignore = "needs Chromium or Firefox, and the program; two minutes"]
fn a_laboratory_works_without_a_terminal() {
    let mut tried = 0;
    for browser in ["Chromium", "Firefox"] {
        let folder = tempfile::tempdir().unwrap();
        let mut studio = Studio::start(folder.path());
        let started = Instant::now();
        let page: Option<Box<dyn Page>> = match browser {
            "Chromium" => Chromium::open_at(&studio.address, studio.own()).map(|page| Box::new(page) as Box<dyn Page>),
            _ => Firefox::open_at(&studio.address, studio.own()).map(|page| Box::new(page) as Box<dyn Page>),
        };
        let Some(mut page) = page else {
            println!("skipped: no {browser}");
            continue;
        };
        tried += 1;
        let paint = page.ask("performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null");
        println!("{browser}: first paint after {paint} ms");
        works(&mut *page, folder.path());
        // Chromium names refusals on the console: that predictions are not computed yet, and that a file changed elsewhere.
        let complaints = page.complaints().into_iter().filter(|words| !words.contains("409 (Conflict)"));
        assert_eq!(complaints.collect::<Vec<_>>(), Vec::<String>::new(), "{browser}");
        // What is typed after the studio has ended is marked, with what to do.
        page.ask("location.hash = '#target?design=own.toml'");
        wait(&mut *page, "document.querySelector('[data-focus=value0]') !== null");
        studio.child.kill().unwrap();
        enter(&mut *page, "Value at", "0.5");
        wait(&mut *page, "document.querySelector('[data-focus=value0]').getAttribute('aria-invalid') === 'true'");
        says(&mut *page, "nothing is saved. Start it again");
        println!("{browser}: {:.0} s", started.elapsed().as_secs_f64());
    }
    println!("{tried} browsers");
}

/// The whole loop in an empty folder.
fn works(page: &mut dyn Page, folder: &Path) {
    let raw = slipgrid_tests::repository().join("calibration/synthetic-polymer/traces");
    let text = |name: &str| fs::read_to_string(raw.join(name)).unwrap();
    let file = |path: &str| fs::read_to_string(folder.join(path)).unwrap();
    page.ask(HAND);
    // A new material: its raw traces, and a map.
    enter(page, "Name of a new material", "pom");
    press(page, "Start a material");
    says(page, "Drop traces of the tribometer");
    says(page, "µ dynamic");
    // It has its name, and no number that the user did not enter: nothing is fitted before.
    until(|| file("pom/calibration.toml").contains("name = \"pom\""));
    until(|| file("pom/flat.csv").ends_with("mu_dynamic_std\n"));
    assert!(!file("pom/calibration.toml").contains("\nyoungs_modulus"));
    press(page, "Fit the material");
    says(page, "Failed: slipgrid calibrate");
    wait(page, "/youngs_modulus_gpa: is missing/.test(document.querySelector('.job .stage')?.textContent ?? '')");
    for (name, text) in [("Source", "made"), ("Young's modulus", "0.4"), ("Density", "1.4"), ("Radius", "5")] {
        enter(page, name, text);
    }
    let map = folder.join("made.asc");
    let made = program()
        .args(["--quiet", "synthesize", "--pixels", "64", "--waves", "4:30", "-o"])
        .arg(&map)
        .status()
        .unwrap();
    assert!(made.success());
    let mut dropped: Vec<(String, String)> = TRACES.map(|name| (name.to_owned(), text(name))).into();
    dropped.push(("flat-map.asc".to_owned(), fs::read_to_string(&map).unwrap()));
    fs::remove_file(map).unwrap();
    // Files that are no traces are not ticked, and get no force. A text of heights is a map.
    let heights = "0.1\t0.2\t0.3\t0.2\t0.1\t0.2\t0.3\t0.4\n".repeat(9);
    for (name, text) in [
        ("map.txt", "# Width: 2 um\n0.1\t0.2\n0.3\t0.4\n"),
        ("table.csv", "force_n,mu_dynamic\n40,0.2\n"),
        ("heights.txt", &*heights),
    ] {
        dropped.push((name.to_owned(), text.to_owned()));
    }
    // Traces of another material have the names of these.
    fs::create_dir_all(folder.join("other/traces")).unwrap();
    fs::write(folder.join("other/traces/flat-300N-1.csv"), text("flat-300N-1.csv")).unwrap();
    drop_files(page, ".page > .drop", &dropped);
    says(page, "Exports that are not used yet");
    enter(page, "Speed in mm/s of pom/traces/flat-160N-1.csv", "5");
    enter(page, "Humidity in % of pom/traces/flat-160N-1.csv", "50");
    press(page, "Add 5 files to the material");
    says(page, "map.txt Not read as a trace: has no line that names its columns");
    says(page, "table.csv Not read as a trace: is a table of friction coefficients");
    wait(
        page,
        "[...document.querySelectorAll('section.card h3')].some(own => own.textContent === 'traces/heights.txt')",
    );
    fs::remove_file(folder.join("pom/traces/heights.txt")).unwrap();
    wait(page, "named('input', 'Force in N of pom/traces/map.txt')?.value === ''");
    // A file that nothing reads is not copied.
    drop_files(page, ".page > .drop", &[("friction.xlsx".to_owned(), "PK".to_owned())]);
    says(page, "friction.xlsx: no format that is read here. Save traces as CSV");
    assert!(!folder.join("pom/traces/friction.xlsx").exists());
    // The traces hold a torque: the page says what is missing.
    says(page, "`effective_radius_mm` in [traces]");
    let calibration = file("pom/calibration.toml");
    assert!(
        calibration.contains("force_n = 300") && calibration.contains("\"traces/flat-300N-2.csv\""),
        "{calibration}"
    );
    press(page, "How traces are read");
    press(page, "More settings");
    enter(page, "Effective radius", "25");
    enter(page, "Specimens", "3");
    says(page, "Dynamic friction by condition");
    press(page, "Use for the area law");
    press(page, "It was measured");
    wait(page, "says('In use for the area law')");
    // What was typed last is fitted.
    wait(page, "enter(\"Young's modulus\", '0,38') && press('Fit the material')");
    wait(page, "document.querySelector('.report iframe') !== null");
    let material = file("pom-material.toml");
    assert!(material.contains("youngs_modulus_gpa = 0.38"), "{material}");

    // A target, by keyboard, and the sliders beside it.
    press(page, "Target");
    enter(page, "Name of a new design", "seal");
    press(page, "Start a design");
    wait(page, "document.querySelectorAll('[role=slider]').length > 1");
    page.ask("document.querySelector('[role=slider]').focus()");
    page.ask("document.querySelector('[role=slider]').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowDown', bubbles: true }))");
    until(|| file("seal.toml").contains("value = [0.945, 0.88]"));
    wait(page, "document.querySelector('[data-focus=value0]').value === '0.945'");
    assert!(file("seal.toml").contains("# one number, or one per pressure"), "comments are lost");
    enter(page, "Value at 0.65 MPa", "");
    says(page, "Value at 0.65 MPa: enter a number.");
    // That stays while other values are saved, until there is a number.
    enter(page, "Value at 2.6 MPa", "0.87");
    until(|| file("seal.toml").contains("value = [0.945, 0.87]"));
    enter(page, "Value at 2.6 MPa", "0.88");
    until(|| file("seal.toml").contains("value = [0.945, 0.88]"));
    std::thread::sleep(Duration::from_secs(1));
    says(page, "Value at 0.65 MPa: enter a number.");
    enter(page, "Value at 0.65 MPa", "0.945");
    wait(page, "!says('enter a number.')");
    // Another kind of target keeps the numbers; a comma of two meanings is refused.
    let target = |key: &str| {
        let text = file("seal.toml");
        text.lines()
            .find(|line| line.starts_with(&format!("{key} = ")))
            .map(|line| line.split('#').next().unwrap().trim().to_owned())
    };
    let known = target("value").unwrap();
    for (mode, key) in [("highest", "highest"), ("goal", "goal"), ("value", "value")] {
        enter(page, "The target is", mode);
        until(|| target(key).is_some());
        let written = target(key).unwrap();
        assert!(key == "goal" || written == known.replace("value", key), "{written}");
    }
    enter(page, "Humidity", "4,5");
    says(page, "One number or two? Write 4.5 or 4; 5.");
    // What was not saved stays where the form is drawn anew.
    press(page, "Further conditions");
    press(page, "Add to Further conditions");
    wait(page, "document.querySelector('[data-key=\"also_at.0.speed_mm_s\"]') !== null");
    assert_eq!(page.ask("document.querySelector('[data-key=\"condition.humidity_pct\"]').value"), "4,5");
    says(page, "One number or two? Write 4.5 or 4; 5.");
    page.ask("import('/assets/api.js').then(api => api.edit('seal.toml', [{ at: ['also_at'], value: null }])) && null");
    until(|| !file("seal.toml").contains("[[also_at]]"));
    wait(page, "/%|No answer/.test(document.querySelector('.chance')?.textContent ?? '')");
    let took = page.ask(
        "(async () => { const slider = document.querySelector('input[type=range]'), took = []; for (let k = 0; k < 40; k++) { \
         slider.value = Number(slider.min) + (k + 1) * (slider.max - slider.min) / 50; const start = performance.now(); \
         slider.dispatchEvent(new Event('input', { bubbles: true })); took.push(performance.now() - start); \
         await new Promise(requestAnimationFrame); } window.took = took.sort((a, b) => a - b); })() && null",
    );
    assert!(took.is_null());
    wait(page, "Array.isArray(window.took)");
    println!("a step of a slider takes {} ms (median) of the page", page.ask("window.took[20]"));

    // The texture, with the bytes of the command line.
    press(page, "Design");
    press(page, "Find the texture");
    wait(page, "document.querySelector('.decision') !== null");
    let copy = tempfile::tempdir().unwrap();
    copy_folder(folder, copy.path());
    fs::remove_dir_all(copy.path().join("out/seal")).unwrap();
    let done = program().args(["--quiet", "optimize", "seal.toml"]).current_dir(copy.path()).output().unwrap();
    assert!(done.status.code().is_some_and(|code| [0, 3].contains(&code)), "{}", String::from_utf8_lossy(&done.stderr));
    for name in ["result.json", "pattern.dxf", "process.toml", "scene.toml"] {
        let read = |folder: &Path| fs::read(folder.join("out/seal").join(name)).unwrap();
        assert!(read(folder) == read(copy.path()), "{name}");
    }

    // A sample of it is cut and measured.
    press(page, "I will cut this");
    says(page, "Added as");
    // The trial is known again, and no input of the result.
    press(page, "Trials");
    press(page, "It is cut");
    wait(page, "says('No sample is chosen.')");
    press(page, "Design");
    says(page, "Added as cut-1");
    assert_eq!(page.ask("says('changed after the run')"), json!(false), "{}", page_text(page));
    press(page, "Material");
    enter(page, "Density", "1.41");
    until(|| file("pom/calibration.toml").contains("density_g_cm3 = 1.41"));
    says(page, "pom/calibration.toml changed after the run of this result began. Fit the material again.");
    press(page, "Design");
    says(page, "pom/calibration.toml changed after the run of this result began. Find the texture again.");
    press(page, "Trials");
    let measured =
        [80, 300].map(|force| (format!("cut-1-{force}N-5mm_s-50pct.csv"), text(&format!("patterned-{force}N-1.csv"))));
    wait(page, "says('No sample is chosen.')");
    drop_files(page, "article .drop", &measured);
    press(page, "Add 2 files to the trials");
    says(page, "Traces: 2; conditions: 2");
    // A trace that was attached by mistake is taken off, and can be added again.
    let attached = file("pom/calibration.toml");
    press(page, "Traces: 2");
    press(page, "Remove traces/cut-1-80N-5mm_s-50pct.csv");
    says(page, "Traces: 1; conditions: 1");
    assert!(!file("pom/calibration.toml").contains("cut-1-80N"));
    press(page, "Add 1 file to the trials");
    says(page, "Traces: 2; conditions: 2");
    let sorted = |text: &str| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert_eq!(sorted(&file("pom/calibration.toml")), sorted(&attached));
    press(page, "Material");
    press(page, "Traces: 5");
    press(page, "Remove traces/flat-300N-2.csv");
    says(page, "Traces: 4; conditions: 4");
    press(page, "Add 1 file to the material");
    says(page, "Traces: 5; conditions: 4");
    // Of a texture that was measured another sample can be cut.
    press(page, "Design");
    press(page, "I will cut this again");
    until(|| file("pom/calibration.toml").contains("cut-2"));
    page.ask("import('/assets/api.js').then(api => api.edit('pom/calibration.toml', [{ at: ['trial', 1], value: null }])) && null");
    until(|| !file("pom/calibration.toml").contains("cut-2"));
    press(page, "Trials");
    press(page, "What was learned");
    says(page, "Ratio to the flat sample, predicted from earlier trials and measured");
    says(page, ", before any trial");
    press(page, "What to cut next");
    says(page, "Chance that one of these");
    assert!(folder.join("out/seal-next/next-1/pattern.dxf").is_file());

    // A file that another program changes shows up; one that is wrong is named with its line.
    press(page, "Files");
    fs::write(folder.join("seal.toml"), format!("# by another hand\n{}", file("seal.toml"))).unwrap();
    press(page, "seal.toml");
    says(page, "# by another hand");
    fs::write(folder.join("seal.toml"), file("seal.toml").replace("[bounds]", "[bonds]")).unwrap();
    says(page, "bonds");
    // A page without a field for a message leads to its line.
    let misspelt = file("seal.toml").replace("[bonds]", "[bounds]").replace("min_land_um", "min_lnad_um");
    fs::write(folder.join("seal.toml"), misspelt).unwrap();
    press(page, "Design");
    press(page, "Edit line");
    says(page, "# by another hand");
    // What another tab put in the place where this one adds a trial is kept, and seen here though the file keeps its time.
    let pattern = json!({ "width_um": 99, "spacing_um": 990, "depth_um": 9 });
    let trial = |name: &str| json!([{ "at": ["trial", 1], "value": { "name": name, "pattern": pattern } }]);
    page.ask(&format!(
        "import('/assets/api.js').then(async api => {{ const path = 'pom/calibration.toml', {{ digest }} = await api.load(path), \
         other = new XMLHttpRequest(); other.open('POST', `/api/edit?path=${{path}}`, false); \
         other.setRequestHeader('Content-Type', 'application/json'); other.send(JSON.stringify({{ digest, edits: {} }})); \
         api.edit(path, {}).catch(error => {{ window.refused = error.message; }}); }}) && null",
        trial("theirs"),
        trial("ours")
    ));
    wait(page, "/Nothing was saved/.test(window.refused ?? '')");
    assert!(file("pom/calibration.toml").contains("theirs") && !file("pom/calibration.toml").contains("ours"));
    // A design with the material's numbers in its own file.
    let own = program().args(["--quiet", "new", "design", "own.toml"]).current_dir(folder).status().unwrap();
    assert!(own.success());
    wait(page, "document.querySelector('#choices option[value=\"own.toml\"]') !== null");
    page.ask("location.hash = '#target?design=own.toml'");
    says(page, "Young's modulus");
    for page_name in ["Material", "Target", "Design", "Trials", "Files"] {
        press(page, page_name);
        std::thread::sleep(Duration::from_millis(500));
        let cut_off = page.ask(pages::CUT_OFF);
        // The link that skips the tabs is off the window until it has the focus.
        let cut_off = cut_off.as_array().unwrap().iter().filter(|own| !own.to_string().contains("Skip to the page"));
        assert_eq!(cut_off.count(), 0, "{page_name}: {}", page.ask(pages::CUT_OFF));
        assert_eq!(page.ask(pages::CONTRAST), json!([]), "{page_name}");
        assert_eq!(page.ask(pages::SKIPPED_LEVELS), json!([]), "{page_name}");
    }
}

fn copy_folder(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            fs::create_dir_all(&target).unwrap();
            copy_folder(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}
