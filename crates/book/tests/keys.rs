//! Checks that the chapters of keys and the schemas are generated from the current types.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value as Json;
use slipgrid_book::keys::{all_keys, keys, words};
use slipgrid_book::links::anchors;
use slipgrid_book::schema::{Accepted, default, file_schema, violations};
use slipgrid_design::results::SimulationReport;
use slipgrid_design::{DesignReport, NextReport};
use slipgrid_io::{record_schema, sheet_schema};
use slipgrid_laser::export::{ProcessSheet, SectorsSheet};
use slipgrid_report::calibration::FitReport;
use slipgrid_report::trials::TrialsReport;
use slipgrid_traces::columns::Channel;
use toml::Value;

use crate::probes::{KINDS, Kind, changed};
use crate::{book, files, keep, program, root, text};

/// Schema version of the input files.
const VERSION: u32 = 1;

#[test]
fn schemas_are_generated_from_the_types_that_read() {
    for kind in KINDS {
        let now = file_schema(kind.schema(), (kind.name, VERSION), &kind.accepted());
        let text = serde_json::to_string_pretty(&now).unwrap() + "\n";
        let name = format!("{}-{VERSION}.json", kind.name);
        keep(&book().join("schemas").join(&name), &text);
        // Its forms are drawn from them.
        keep(&root().join("crates/studio/schemas").join(&name), &text);
    }
}

#[test]
fn schemas_have_absolute_ids_and_references_that_resolve() {
    let is_absolute = |id: &str| {
        let (scheme, rest) = id.split_once(':').unwrap_or_default();
        scheme.starts_with(|first: char| first.is_ascii_lowercase())
            && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
            && !rest.is_empty()
            && id.bytes().all(|byte| byte.is_ascii_graphic() && !b"\"<>\\^`{|}#".contains(&byte))
    };
    fn references<'a>(value: &'a serde_json::Value, found: &mut Vec<&'a str>) {
        match value {
            serde_json::Value::Object(keys) => {
                found.extend(keys.get("$ref").and_then(serde_json::Value::as_str));
                keys.values().for_each(|value| references(value, found));
            }
            serde_json::Value::Array(values) => values.iter().for_each(|value| references(value, found)),
            _ => {}
        }
    }
    let mut ids = BTreeSet::new();
    for entry in std::fs::read_dir(book().join("schemas")).unwrap() {
        let path = entry.unwrap().path();
        let schema: serde_json::Value = serde_json::from_str(&text(&path)).unwrap();
        let id = schema["$id"].as_str().unwrap().to_owned();
        assert!(is_absolute(&id), "{}: {id}", path.display());
        assert!(ids.insert(id), "{}", path.display());
        let mut found = Vec::new();
        references(&schema, &mut found);
        for reference in found {
            // Schemas stand alone: what they name lies within them.
            let pointer = reference.strip_prefix('#').unwrap();
            assert!(schema.pointer(pointer).is_some(), "{}: {reference}", path.display());
        }
    }
    assert!(ids.len() >= KINDS.len());
    assert!(!is_absolute("slipgrid-design-1") && !is_absolute("design-1.json#") && is_absolute("https://a.b/c.json"));
}

#[test]
fn the_chapters_of_keys_are_generated_from_the_types_that_read() {
    let mut list = "# Keys of all files\n\nThese chapters are generated from the types that read the files. A key that is **bold** is \
                    required. The column \"accepted\" has what the program answers to a wrong value; where it is empty, every \
                    value of the type is accepted. [Files with keys](files.md) says which file is for what, and how an editor \
                    checks keys.\n\n| file | tables |\n|---|---|\n"
        .to_owned();
    let mut described = Vec::new();
    for kind in &KINDS {
        let page = format!("keys/{}.md", kind.name);
        let mut chapter = format!("# Keys of a {}\n\n{}\n", kind.name, kind.meaning);
        describe(kind, (kind.schema(), ""), &kind.accepted(), &mut described, &mut chapter);
        keep(&book().join("reference").join(&page), &chapter);
        let tables = chapter.lines().filter_map(|line| line.strip_prefix("## `")?.strip_suffix('`'));
        let tables = tables.map(|table| format!("[`{table}`]({page}#{})", anchor(table))).collect::<Vec<_>>();
        let _ = writeln!(list, "| [{}]({page}) | {} |", kind.name, tables.join(", "));
    }
    keep(&book().join("reference/keys.md"), &list);
}

/// Anchor of a heading.
fn anchor(heading: &str) -> String {
    anchors(&format!("# {heading}")).remove(0)
}

#[test]
fn the_chapter_of_columns_is_generated_from_what_reads_them() {
    let mut chapter = "# Columns of traces\n\nThis chapter is generated from the code that reads the exports. Of a title only letters and digits \
                       are compared, whether capital or small: `Normal force`, `normal_force` and `NormalForce` are the same. The unit stands behind the \
                       title in brackets, behind a slash or an underscore, or in a line of its own below the titles. Without a unit, the \
                       first unit of this table is assumed; a position without a unit is not read. Separators are tabs, semicolons or commas; the decimal \
                       sign is a point or a comma. Columns with other titles are not read, and may be empty, unless \
                       `columns` in `[traces]` gives them a meaning.\n\n\
                       Titles in the third column count only where no column has one of the second. Several columns of one kind must hold the same \
                       numbers (the same amounts, of a friction force), or `columns` must name one of them: as `columns = { time = \"Time (s) #2\" }` \
                       where both have one title, and as `columns = { normal_force = \"none\" }` where none is to be read. A friction \
                       coefficient beside a torque or friction force is only compared with it.\n\n\
                       | column | titles | otherwise | units |\n|---|---|---|---|\n"
        .to_owned();
    let listed =
        |names: std::str::SplitWhitespace<'_>| names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    for channel in Channel::ALL {
        let [names, secondary] = [channel.names(), channel.secondary_names()].map(listed);
        let _ = writeln!(chapter, "| {} | {names} | {secondary} | {} |", channel.title(), channel.unit_words());
    }
    keep(&book().join("reference/trace-columns.md"), &chapter);
}

/// Records of the commands: name, schema version, schema, file and commands that write it, and chapter.
type Record = (&'static str, u32, fn() -> Json, &'static str, &'static str);
const RECORDS: [Record; 5] = [
    ("result", 2, record_schema::<DesignReport>, "result.json of `optimize`", "result-json.md"),
    ("next", 2, record_schema::<NextReport>, "result.json of `next`", "next-json.md"),
    ("trials", VERSION, record_schema::<TrialsReport>, "result.json of `trials`", "trials-json.md"),
    ("fit", VERSION, record_schema::<FitReport>, "fit.json of `calibrate --report`", "fit-json.md"),
    ("simulation", VERSION, record_schema::<SimulationReport>, "result.json of `simulate`", "simulation-json.md"),
];

#[test]
fn the_chapters_of_results_are_generated_from_the_types_that_are_written() {
    for (name, version, schema, commands, page) in RECORDS {
        let mut chapter = format!(
            "# Keys of {commands}\n\nThis chapter is generated from the types that are written. A key that is **bold** \
             is always there; others are left out, or null, where they do not apply. Numbers that are not known are null. \
             Schema: [{name}-{version}.json](../schemas/{name}-{version}.json).\n"
        );
        record((&schema(), ""), &mut Vec::new(), &mut chapter);
        let now = file_schema(&schema(), (name, version), &Accepted::new());
        keep(
            &book().join(format!("schemas/{name}-{version}.json")),
            &(serde_json::to_string_pretty(&now).unwrap() + "\n"),
        );
        keep(&book().join("reference").join(page), &chapter);
    }
}

/// Process sheets: title, schema, commands that write it, and chapter.
type Sheet = (&'static str, fn() -> Json, &'static str, &'static str);
const SHEETS: [Sheet; 2] = [
    (
        "process.toml",
        sheet_schema::<ProcessSheet>,
        "`optimize`, `next` and `export` write this sheet",
        "process-toml.md",
    ),
    (
        "process.toml with sectors",
        sheet_schema::<SectorsSheet>,
        "`next --one-disc` writes this sheet for a specimen that holds several samples",
        "process-toml-sectors.md",
    ),
];

#[test]
fn the_chapters_of_process_sheets_are_generated_from_the_types_that_are_written() {
    for (name, schema, commands, page) in SHEETS {
        let mut chapter = format!(
            "# Keys of {name}\n\n{commands}. This chapter is generated from the types that are written. A key that is **bold** is \
             always there; others are left out where they do not apply. Units stand in the keys. [From result to \
             laser](../tutorials/to-the-laser.md) says how the numbers follow from the lines.\n"
        );
        let schema = schema();
        record((&schema, ""), &mut Vec::new(), &mut chapter);
        for (path, key) in all_keys(&schema) {
            assert!(key.meaning().ends_with('.'), "{name}: {path}: {}", key.meaning());
        }
        keep(&book().join("reference").join(page), &chapter);
    }
}

/// Writes the keys of the record at `path` and of its inner records into the chapter, equal tables once.
fn record((table, path): (&Json, &str), described: &mut Vec<Json>, chapter: &mut String) {
    if described.contains(&table["properties"]) {
        return;
    }
    described.push(table["properties"].clone());
    if !path.is_empty() {
        let _ = write!(chapter, "\n## `{path}`\n");
    }
    chapter.push_str("\n| key | type | unit | meaning |\n|---|---|---|---|\n");
    for key in keys(table) {
        let name = if key.is_required { format!("**`{}`**", key.name) } else { format!("`{}`", key.name) };
        let cells = [&name, &*words(key.schema), key.unit(), key.meaning()];
        let _ = writeln!(chapter, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
    }
    for key in keys(table) {
        if let Some(inner) = key.table() {
            record((inner, &key.path(path)), described, chapter);
        }
    }
}

/// Small design with the lines `wanted` in its target.
fn small_design(wanted: &str) -> String {
    format!(
        "[material]\nyoungs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.08\n\
         friction = {{ static_mean = 0.30, dynamic_mean = 0.27, dynamic_std_error = 0.003 }}\n\
         area_law = {{ pressure_mpa = [0.7, 2.6, 26.0], factor = [1.0, 0.8, 0.3] }}\n[target]\nquantity = \"ratio\"\n\
         pressure_mpa = 2.6\n{wanted}\n[bounds]\nwidth_um = [100, 200]\nspacing_um = [200, 400]\n\
         depth_um = [5, 20]\n[limits]\ndepth_per_burst_um = 1.1\n[laser]\nspot_um = 25\nrepetition_hz = 20000\n\
         speed_mm_s = 200\nhatch_um = 12.5\n[specimen]\nshape = \"disc\"\ndiameter_mm = 2\n[sample]\nlayer_um = 60\nblock_um = 10\n\
         [tolerances]\nwidth_std_um = 4.0\n"
    )
}

/// Runs the program in `folder` and validates the result.json that it writes into `out` by the schema `name`.
fn obeys(folder: &Path, name: &str, arguments: &[&str], out: &str) {
    let output = program().current_dir(folder).args(arguments).args(["-o", out]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let version = RECORDS.iter().find(|(record, ..)| *record == name).unwrap().1;
    let known: serde_json::Value =
        serde_json::from_str(&text(&book().join(format!("schemas/{name}-{version}.json")))).unwrap();
    let written = text(&folder.join(out).join("result.json"));
    let found = violations(&known, &serde_json::from_str(&written).unwrap());
    assert!(found.is_empty(), "{name}: {arguments:?}: {found:?}");
}

/// The results of two commands obey the schemas, and every key of the process sheet is described.
#[test]
fn results_obey_their_schemas() {
    let folder = tempfile::tempdir().unwrap();
    let write = |file: &str, design: String| std::fs::write(folder.path().join(file), design).unwrap();
    let near = small_design("value = 0.95\ntolerance = 0.02");
    write("d.toml", near + "[trade_offs]\ngoals = [\"misfit\", \"volume\"]\n");
    // A goal has no demand at either end, a one-sided band has one.
    write("goal.toml", small_design("goal = \"lowest\""));
    write("band.toml", small_design("highest = 0.97"));
    obeys(folder.path(), "result", &["optimize", "d.toml", "--table", "--no-explorer"], "out");
    obeys(folder.path(), "simulation", &["simulate", "out/scene.toml", "--fidelity", "steady"], "out/scene");
    obeys(folder.path(), "result", &["optimize", "goal.toml", "--no-explorer"], "goal");
    obeys(folder.path(), "result", &["optimize", "band.toml", "--no-explorer"], "band");
    obeys(folder.path(), "next", &["next", "d.toml", "--count", "2"], "next");
    let calibration = root().join("calibration/synthetic-polymer/calibration.toml");
    obeys(folder.path(), "trials", &["trials", calibration.to_str().unwrap()], "trials");
    // Every key of the process sheet is described in its chapter.
    let sheet: toml::Table = text(&folder.path().join("out/process.toml")).parse().unwrap();
    assert_eq!(violations(&SHEETS[0].1(), &serde_json::to_value(&sheet).unwrap()), [""; 0]);
    assert_eq!(sheet["schema"].as_integer(), Some(VERSION.into()));
    // Cut in seconds: neither the page nor the sheet says 0 minutes.
    let seconds = sheet["work"]["estimated_time_s"].as_float().unwrap();
    let page = text(&folder.path().join("out/report.html"));
    let told = page.split_once("time under the laser").unwrap().1.chars().take(60).collect::<String>();
    assert!(seconds < 60.0 && told.contains(" s<") && !told.contains("min"), "{seconds} s: {told}");
    let chapter = text(&book().join("reference/process-toml.md"));
    let work = sheet["work"].as_table().unwrap();
    for key in ["depths_across_um", "line_distance_um", "least_line_distance_um", "depth_step_um"] {
        assert!(work.contains_key(key) && chapter.contains(&format!("`{key}`")), "{key}");
    }
}

/// Writes the table at `path` and its inner tables into the chapter; a table described before is referred to.
fn describe(
    kind: &Kind,
    (table, path): (&Json, &str),
    accepted: &Accepted,
    described: &mut Vec<(Json, &'static str, String)>,
    chapter: &mut String,
) {
    let title = if path.is_empty() { "Outermost keys".to_owned() } else { format!("`[{path}]`") };
    let _ = write!(chapter, "\n## {title}\n\n");
    if let Some((_, before, title)) = described.iter().find(|(keys, ..)| *keys == table["properties"]) {
        let _ = writeln!(chapter, "The same keys as [{title} of a {before}]({before}.md#{}).", anchor(title));
        return;
    }
    described.push((table["properties"].clone(), kind.name, title));
    chapter.push_str("| key | type | unit | when absent | accepted | meaning |\n|---|---|---|---|---|---|\n");
    for key in keys(table) {
        let path = key.path(path);
        let name = if key.is_required { format!("**`{}`**", key.name) } else { format!("`{}`", key.name) };
        let range = accepted.get(&path).map_or(String::new(), |range| {
            let range = range.split("; ").next().unwrap_or(range).trim_start_matches("a number ");
            // Its unit has a column of its own.
            let unit = range.rsplit_once(' ').filter(|(_, last)| last.parse::<f64>().is_err());
            unit.map_or(range, |(number, _)| number).to_owned()
        });
        let range = accepted.get(&path).filter(|range| !range.starts_with("a number ")).map_or(range, Clone::clone);
        let default = key.default().unwrap_or(if key.is_required { "required" } else { "-" });
        let cells = [&name, &*words(key.schema), key.unit(), default, &range, key.meaning()];
        let _ = writeln!(chapter, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
    }
    for key in keys(table) {
        if let Some(inner) = key.table() {
            describe(kind, (inner, &key.path(path)), accepted, described, chapter);
        }
    }
}

#[test]
fn every_key_has_a_meaning_and_the_readers_know_no_other() {
    for kind in KINDS {
        let keys = all_keys(kind.schema());
        for (path, key) in &keys {
            assert!(key.meaning().ends_with('.'), "{}: {path}: {:?}", kind.name, key.meaning());
        }
        // The reader lists the keys of a table where it meets one that it does not know.
        let tables = std::iter::once(String::new())
            .chain(keys.iter().filter(|(_, key)| key.table().is_some()).map(|(path, _)| format!("{path}.")));
        let mut seen = 0;
        for table in tables {
            let own: BTreeSet<&str> = keys
                .iter()
                .filter_map(|(path, _)| path.strip_prefix(&*table))
                .filter(|key| !key.contains('.'))
                .collect();
            for (file, _, spoiled) in changed(&kind, &format!("{table}no_such_key"), &Value::Integer(1)) {
                let refused = kind.read(&file, &spoiled).unwrap_err();
                let listed = refused.expected.clone().unwrap_or_default();
                let Some(listed) = listed.strip_prefix("one of ") else { continue };
                seen += 1;
                assert_eq!(listed.split(", ").collect::<BTreeSet<_>>(), own, "{}: {table}", kind.name);
            }
        }
        assert!(seen >= 2, "{}: {seen}", kind.name);
    }
}

/// Whether `table` has an entry at the dotted `path`, looking into the first element of each list of tables.
fn holds(table: &toml::Table, path: &str) -> bool {
    let mut inner = Some(Value::Table(table.clone()));
    for part in path.split('.') {
        inner = inner.and_then(|value| match value {
            Value::Array(list) => list.first().cloned(),
            other => Some(other),
        });
        inner = inner.and_then(|value| value.get(part).cloned());
    }
    inner.is_some()
}

/// Keys whose default is applied where they are used, not where they are read.
const TAKEN_LATER: [&str; 3] = ["laser.wall_taper_deg", "laser.exposure", "trial.sample_std"];

/// Writing out a default does not change what is read.
#[test]
fn defaults_are_what_holds_where_a_key_is_absent() {
    let (mut checked, mut wrong) = (0, Vec::new());
    for kind in KINDS {
        for (path, key) in all_keys(kind.schema()) {
            let Some(default) = default(&key) else { continue };
            let default = Value::try_from(&default).unwrap();
            let table = path.rsplit_once('.').map_or("", |(table, _)| table);
            for (file, example, changed) in changed(&kind, &path, &default) {
                // A table that is absent may say something by that.
                if !table.is_empty() && !holds(&example, table) {
                    continue;
                }
                // Where the key stands already its default says nothing of its absence.
                if holds(&example, &path) {
                    continue;
                }
                if let (Ok(before), Ok(after)) = (kind.read(&file, &example), kind.read(&file, &changed)) {
                    checked += 1;
                    if before != after && !TAKEN_LATER.contains(&path.as_str()) {
                        wrong.push(format!("{}: {path} = {default}", kind.name));
                    }
                    break;
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(checked > 40, "{checked} defaults were compared");
}

/// Kind of the file `text`, by its tables; `None` for files without a schema.
fn kind_of(path: &str, text: &str) -> Option<&'static str> {
    let table: toml::Table = text.parse().ok()?;
    let has = |key: &str| table.contains_key(key);
    if path.contains("process") || path.ends_with("Cargo.toml") || path.ends_with("book.toml") {
        return None;
    }
    match () {
        () if has("bounds") => Some("design"),
        () if has("load") => Some("scene"),
        () if has("measurements") || has("traces") => Some("calibration"),
        () if has("grid") || has("list") || has("base") => Some("campaign"),
        () if has("friction") => Some("material"),
        () => None,
    }
}

#[test]
fn every_shipped_file_obeys_its_schema_and_a_misspelt_key_does_not() {
    let mut judged = BTreeMap::new();
    let folders = ["designs", "calibration", "crates/cli/src/templates", "tests/hard_cases/scenes", "tests/accuracy"];
    for path in folders.iter().flat_map(|folder| files(&root().join(folder), ".toml")) {
        let own = text(&path);
        let Some(kind) = kind_of(&path.to_string_lossy(), &own) else { panic!("{}", path.display()) };
        let known: serde_json::Value =
            serde_json::from_str(&text(&book().join(format!("schemas/{kind}-{VERSION}.json")))).unwrap();
        let table: toml::Table = own.parse().unwrap();
        let found = violations(&known, &serde_json::to_value(&table).unwrap());
        let reader = KINDS.into_iter().find(|other| other.name == kind).unwrap();
        // A schema is at most as strict as the reader; some hard cases are there to be refused.
        assert!(found.is_empty() || reader.read(&path, &table).is_err(), "{}: {found:?}", path.display());
        if found.is_empty() {
            *judged.entry(kind).or_insert(0) += 1;
        }
        for key in table.keys() {
            let mut misspelt = table.clone();
            let value = misspelt.remove(key).unwrap();
            misspelt.insert(format!("{key}x"), value);
            let found = violations(&known, &serde_json::to_value(&misspelt).unwrap());
            assert!(found.contains(&format!("{key}x is not a known key")), "{}: {found:?}", path.display());
        }
    }
    assert!(
        judged["design"] > 8 && judged["scene"] > 80 && judged["calibration"] > 2 && judged["campaign"] > 0,
        "{judged:?}"
    );
}

#[test]
fn examples_are_accepted_by_reader_and_schema() {
    for kind in KINDS {
        let known = file_schema(kind.schema(), (kind.name, VERSION), &kind.accepted());
        let mut read = 0;
        for (path, example) in kind.examples() {
            let found = violations(&known, &serde_json::to_value(&example).unwrap());
            if kind.read(&path, &example).is_ok() {
                read += 1;
                assert!(found.is_empty(), "{}: {found:?}\n{example}", kind.name);
            }
        }
        assert!(read > 0, "{}", kind.name);
    }
}
