//! Synthetic tribometer traces: kinds of columns, separators, motions and faults.

use std::fmt::Write as _;

use serde_json::Value;

use crate::Case;
use crate::place::Place;
use crate::random::Random;
use crate::record::Record;

/// Refused tables, one a line, with escaped line ends and tabs; after two spaces an option.
const REFUSED: &str = include_str!("inputs/exports.txt");

/// Distance of a specimen from the axis, in metres.
const RADIUS_M: f64 = 0.0381;

/// Options of `traces` for a trace of [`rows`].
const OPTIONS: &str = "--effective-radius-mm 38.1 --force-n 150 --speed-mm-s 0.05 --humidity-pct 40 --window-s 10,40";

/// Rows of time in s, friction coefficient and normal force in N, for 45 s at 20 Hz with a peak at the onset of sliding
/// and noise of 1 %.
fn rows(seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    let mut noise = move |size: f64| size * (0..4).map(|_| random.unit() - 0.5).sum::<f64>();
    (0..=900)
        .map(|sample| {
            let t = f64::from(sample) * 0.05;
            let mu = if t < 0.5 { 0.62 * t } else { 0.25 + 0.06 * (0.5 - t).exp() };
            [t, mu + noise(0.004), 150.0 + noise(1.0)]
        })
        .collect()
}

/// Table with commas between its fields; `line` formats a row.
fn table(titles: &str, rows: &[[f64; 3]], line: impl Fn([f64; 3]) -> String) -> String {
    rows.iter().fold(format!("{titles}\n"), |mut text, row| {
        writeln!(text, "{}", line(*row)).unwrap();
        text
    })
}

/// Table with time, torque and normal force.
fn plain(rows: &[[f64; 3]]) -> String {
    table("time_s,torque_nm,normal_force_n", rows, |[t, mu, n]| format!("{t:.2},{:.5},{n:.3}", mu * n * RADIUS_M))
}

/// Exports: name, table and options.
fn exports() -> Vec<(&'static str, String, String)> {
    let good = rows(1);
    let changed = |change: &dyn Fn(usize, &mut [f64; 3])| {
        let mut rows = good.clone();
        rows.iter_mut().enumerate().for_each(|(place, row)| change(place, row));
        plain(&rows)
    };
    let back_and_forth = |[t, mu, n]: [f64; 3]| {
        let sign = if (t / 2.0) as i64 % 2 == 0 { 1.0 } else { -1.0 };
        format!("{t:.2},{:.4},{n:.3}", sign * mu * n)
    };
    let touchdown = table("time_s,Fx,Fz", &good, |[t, mu, n]| {
        let n = n * (t - 4.0).clamp(0.0, 1.0);
        format!("{t:.2},{:.4},{:.3}", mu * n + 0.3, n + 2.4)
    });
    let coefficient = table("time_s,COF,load_n", &good, |[t, mu, n]| format!("{t:.2},{mu:.5},{n:.3}"));
    let coarse: Vec<[f64; 3]> = good.iter().copied().step_by(20).collect();
    // Mean forces of 37.5 and 150 N, in other units, in each other's place, and beside what is stated.
    let forces = |friction: f64, load: f64| {
        table("time_s,Fx,Fz", &good, |[t, mu, n]| format!("{t:.2},{:.6},{:.6}", mu * n * friction, n * load))
    };
    let tables = [
        ("torque", plain(&good)),
        ("load in kN", forces(1.0, 1e-3)),
        ("load in mN", forces(1.0, 1e3)),
        ("load in kgf", forces(1.0, 0.102)),
        ("load in gf", forces(1.0, 102.0)),
        ("forces in each other's place", forces(4.0, 0.25)),
        ("forces likely in each other's place", forces(4.0, 0.6)),
        ("a little more load", forces(1.0, 1.08)),
        ("half of the load", forces(1.0, 0.45)),
        (
            "force",
            table("time_s,friction_force_n,normal_force_n", &good, |[t, mu, n]| format!("{t:.2},{:.4},{n:.3}", mu * n)),
        ),
        ("coefficient", coefficient.clone()),
        ("coefficient alone", table("t,mu", &good, |[t, mu, _]| format!("{t:.2},{mu:.5}"))),
        (
            "decimal commas",
            table("Zeit [s];Drehmoment [mNm];Normalkraft [N]", &good, |[t, mu, n]| {
                format!("{t:.2};{:.2};{n:.3}", 1e3 * mu * n * RADIUS_M).replace('.', ",")
            }),
        ),
        (
            "tabs and units below",
            table("Time\tTz\tFz\ns\tN m\tN", &good, |[t, mu, n]| format!("{t:.2}\t{:.5}\t{n:.3}", mu * n * RADIUS_M)),
        ),
        (
            "kilograms",
            table("time_s,Fx (kgf),Fz (kgf)", &good, |[t, mu, n]| {
                format!("{t:.2},{:.5},{:.4}", mu * n / 9.80665, n / 9.80665)
            }),
        ),
        ("minutes", table("time (min),Fx,Fz", &good, |[t, mu, n]| format!("{:.6},{:.4},{n:.3}", t / 60.0, mu * n))),
        ("a column more", table("time_s,Fx,Fz,Temp", &good, |[t, mu, n]| format!("{t:.2},{:.4},{n:.3},21", mu * n))),
        ("negative", changed(&|_, row| row[1] = -row[1])),
        ("negative force", changed(&|_, row| row[2] = -row[2])),
        (
            "missing numbers",
            changed(&|place, row| {
                if place % 50 == 7 {
                    row[1] = f64::NAN
                }
            }),
        ),
        ("saturated", changed(&|_, row| row[1] = 0.25)),
        (
            "clock back",
            changed(&|place, row| {
                if place == 500 {
                    row[0] = 3.0
                }
            }),
        ),
        (
            "gap",
            changed(&|place, row| {
                if place > 400 {
                    row[0] += 2.5
                }
            }),
        ),
        (
            "no load",
            changed(&|place, row| {
                if place > 600 {
                    row[2] = 0.5
                }
            }),
        ),
        ("drift", changed(&|_, row| row[1] += 0.002 * row[0])),
        ("sticks", changed(&|_, row| row[1] = 0.01 * row[0])),
        ("a coefficient of 143", changed(&|_, row| row[1] *= 572.0)),
        ("a stretch without numbers", changed(&|place, row| row[1] = if place / 200 == 2 { f64::NAN } else { row[1] })),
        ("no numbers after 25 s", changed(&|place, row| row[1] = if place > 500 { f64::NAN } else { row[1] })),
        ("no numbers", changed(&|_, row| row[1] = f64::NAN)),
        ("an offset before touchdown", touchdown.clone()),
        (
            "another speed of the position",
            table("time_s,x_mm,Fx,Fz", &good, |[t, mu, n]| format!("{t:.2},{:.4},{:.4},{n:.3}", 2.0 * t, mu * n)),
        ),
        ("every row twice", plain(&good.iter().flat_map(|row| [*row; 2]).collect::<Vec<_>>())),
        (
            "at rest",
            table("time_s,Fx,Fz,speed_mm_s", &good, |[t, mu, n]| format!("{t:.2},{:.4},{n:.3},0.00001", mu * n)),
        ),
        ("stick-slip", changed(&|_, row| row[1] += 0.03 * (row[0] % 1.0 - 0.5))),
        ("no load at all", changed(&|_, row| row[2] = 0.0)),
        ("another side after 30 s", changed(&|place, row| row[1] *= if place < 600 { 1.0 } else { -1.0 })),
        ("another load", changed(&|_, row| row[2] *= 1.3)),
        ("short", plain(&good[..300])),
        ("no title", plain(&good).lines().skip(1).fold(String::new(), |text, line| text + line + "\n")),
        ("unknown titles", plain(&good).replace("torque_nm", "signal_a")),
        ("unknown unit", plain(&good).replace("torque_nm", "torque (furlong)")),
        ("a field too few", plain(&good).replacen(",", " ", 9)),
        ("two titles alike", table("time_s,Fx,Fx,Fz", &good, |[t, mu, n]| format!("{t:.2},{:.4},1,{n:.3}", mu * n))),
        ("empty", String::new()),
        ("words", "this is no table\n".repeat(5)),
    ];
    let mut exports: Vec<_> = tables.into_iter().map(|(name, text)| (name, text, OPTIONS.to_owned())).collect();
    let reciprocating = table("time_s,Fx,Fz", &good, back_and_forth);
    exports.push(("reciprocating", reciprocating.clone(), format!("{OPTIONS} --reciprocating")));
    exports.push(("reciprocating, not said", reciprocating, OPTIONS.to_owned()));
    exports.push(("no static peak sought", plain(&good), format!("{OPTIONS} --no-static-peak")));
    exports.push(("its zero", touchdown.clone(), format!("{OPTIONS} --zero-s 0,3")));
    exports.push(("zero under load", plain(&good), format!("{OPTIONS} --zero-s 1,3")));
    exports.push(("no strokes", plain(&good), format!("{OPTIONS} --reciprocating")));
    exports.push((
        "few samples of a stroke",
        table("time_s,Fx,Fz", &coarse, back_and_forth),
        format!("{OPTIONS} --reciprocating"),
    ));
    exports.push(("zero of a coefficient", coefficient, format!("{OPTIONS} --zero-s 0,3")));
    for (name, window_s) in [
        ("window beyond", "30,60"),
        ("window backward", "40,10"),
        ("window of no length", "10,10"),
        ("window before the first row", "-1,5"),
        ("window without an end", "0,nan"),
        ("window of half a second", "10,10.5"),
    ] {
        exports.push((name, plain(&good), OPTIONS.replace("--window-s 10,40", &format!("--window-s={window_s}"))));
    }
    for (name, span_s) in [
        ("zero of no length", "2,2"),
        ("zero backward", "3,1"),
        ("zero before the first row", "-1,2"),
        ("zero without an end", "0,inf"),
        ("zero within the window", "0,12"),
        ("zero beyond", "50,60"),
        ("zero of few samples", "1,1.1"),
        ("zero that reaches into the loading", "0,4.5"),
        ("zero after touchdown", "6,9"),
    ] {
        exports.push((name, touchdown.clone(), format!("{OPTIONS} --zero-s={span_s}")));
    }
    exports.push(("no radius", plain(&good), OPTIONS.replace("--effective-radius-mm 38.1", "")));
    exports.push(("three specimens", plain(&good), format!("{} --specimens 3", OPTIONS.replace("150", "50"))));
    exports
}

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = exports()
        .into_iter()
        .map(|(name, text, options)| {
            Case::new(name, true, move || {
                let mut record = Record::new();
                let place = Place::with(&[("a.csv", &text)]);
                place.run(&format!("traces @a.csv {options} -o @out"), &mut record);
                place.record_folder("out", &mut record);
                record
            })
        })
        .collect();
    cases.push(Case::new("three repeats", true, || {
        let tables: Vec<String> = (1..4).map(|seed| plain(&rows(seed))).collect();
        let place = Place::with(&[("a.csv", &tables[0]), ("b.csv", &tables[1]), ("c.csv", &tables[2])]);
        let mut record = Record::new();
        place.run(&format!("traces @a.csv @b.csv @c.csv {OPTIONS} -o @out"), &mut record);
        place.record_folder("out", &mut record);
        record
    }));
    cases.push(Case::new("refused tables", true, || {
        let said = |line: &str| {
            let (text, option) = line.split_once("  ").unwrap_or((line, ""));
            let text = text.replace("\\n", "\n").replace("\\t", "\t").replace("\\r", "\r");
            let (code, _, err) = Place::with(&[("a.csv", &text)]).run_raw(&format!("traces @a.csv {OPTIONS} {option}"));
            (line.to_owned(), Value::from(format!("{code} {}", err.trim())))
        };
        REFUSED.lines().map(said).collect()
    }));
    for (name, files) in [("given twice", "@a.csv @a.csv"), ("copied", "@a.csv @b.csv")] {
        cases.push(Case::new(name, true, move || {
            let text = plain(&rows(1));
            let mut record = Record::new();
            Place::with(&[("a.csv", &text), ("b.csv", &text)]).run(&format!("traces {files} {OPTIONS}"), &mut record);
            record
        }));
    }
    cases
}
