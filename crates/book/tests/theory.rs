//! Draws the pictures of the theory from solutions of the program, and compares them with those of the book.

use std::fmt::Write as _;

use slipgrid::contact::closed_form::persson_area_fraction;
use slipgrid::discrepancy::{
    Conditions, Discrepancy, Features, Hyperparameters, Load as At, Measured, Sensitivity, Trial,
};
use slipgrid::material::{AreaLaw, Elastic, LocalFriction};
use slipgrid::pattern::{Pattern, Planform};
use slipgrid::report::charts;
use slipgrid::report::pictures::trace;
use slipgrid::springblock::{Fidelity, Layer, Load, RunOptions, Scene, SteadyCell, Unwatched, simulate};

use crate::{book, keep, text};

const WHITE: &str = "#FFFFFF";
const INK: &str = "#333333";
const GREY: &str = "#6E6E6E";
const BLUE: &str = "#0072B2";
const RED: &str = "#D55E00";
const GREEN: &str = "#009E73";

/// E* h'rms of the pictures, in pascals.
const SCALE_PA: f64 = 4e6;
/// Threshold pressure of the area law, in pascals.
const THRESHOLD_PA: f64 = 0.01 * SCALE_PA;
/// Pressure of the pictures, in pascals.
const PRESSURE_PA: f64 = 2.6e6;

/// Drawing of 900 x 440 units. Points are in the units of its axes.
struct Drawing {
    svg: String,
    ranges: [[f64; 2]; 2],
}

impl Drawing {
    const FRAME: [[f64; 2]; 2] = [[90.0, 870.0], [380.0, 70.0]];

    fn new(title: &str, ranges: [[f64; 2]; 2]) -> Self {
        let svg = format!(
            "<svg width=\"900\" height=\"440\" viewBox=\"0 0 900 440\" xmlns=\"http://www.w3.org/2000/svg\" \
             font-family=\"sans-serif\" font-size=\"16\" fill=\"{INK}\">\n<rect width=\"900\" height=\"440\" fill=\"{WHITE}\"/>\n\
             <text x=\"90\" y=\"30\" font-size=\"18\" font-weight=\"bold\">{title}</text>\n"
        );
        Self { svg, ranges }
    }

    /// Position on the page, in tenths of a unit.
    fn at(&self, point: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|axis| {
            let ([from, to], [low, high]) = (Self::FRAME[axis], self.ranges[axis]);
            (10.0 * (from + (point[axis] - low) / (high - low) * (to - from))).round() / 10.0
        })
    }

    fn points(&self, points: &[[f64; 2]]) -> String {
        points.iter().map(|point| self.at(*point)).map(|[x, y]| format!("{x},{y}")).collect::<Vec<_>>().join(" ")
    }

    fn line(&mut self, points: &[[f64; 2]], color: &str, width: f64) {
        let points = self.points(points);
        let _ = writeln!(
            self.svg,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"/>"
        );
    }

    fn area(&mut self, points: &[[f64; 2]], color: &str, opacity: f64) {
        let points = self.points(points);
        let _ = writeln!(self.svg, "<polygon points=\"{points}\" fill=\"{color}\" fill-opacity=\"{opacity}\"/>");
    }

    fn dot(&mut self, point: [f64; 2], color: &str) {
        let [x, y] = self.at(point);
        let _ = writeln!(self.svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"6\" fill=\"{color}\"/>");
    }

    fn label(&mut self, point: [f64; 2], words: &str, anchor: &str, color: &str) {
        let [x, y] = self.at(point);
        let _ =
            writeln!(self.svg, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" fill=\"{color}\">{words}</text>");
    }

    /// Draws the axes with numbers at multiples of `steps`, and their titles.
    fn axes(&mut self, steps: [f64; 2], titles: [&str; 2]) {
        let [[left, right], [low, high]] = self.ranges;
        let numbers = |[from, to]: [f64; 2], step: f64| {
            let decimals = (-step.log10().floor()).max(0.0) as usize;
            let count = ((to - from) / step + 1e-9).floor() as u32;
            (0..=count).map(move |index| from + f64::from(index) * step).map(move |v| (v, format!("{v:.decimals$}")))
        };
        self.line(&[[left, high], [left, low], [right, low]], INK, 1.2);
        let [edge, bottom] = self.at([left, low]);
        for (value, number) in numbers(self.ranges[0], steps[0]) {
            let x = self.at([value, low])[0];
            let _ =
                writeln!(self.svg, "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{number}</text>", bottom + 22.0);
        }
        for (value, number) in numbers(self.ranges[1], steps[1]) {
            let y = self.at([left, value])[1];
            let _ =
                writeln!(self.svg, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{number}</text>", edge - 9.0, y + 5.0);
        }
        let _ = writeln!(self.svg, "<text x=\"480\" y=\"428\" text-anchor=\"middle\">{}</text>", titles[0]);
        let _ = writeln!(self.svg, "<text x=\"90\" y=\"56\" fill=\"{GREY}\">{}</text>", titles[1]);
    }

    fn end(self) -> String {
        self.svg + "</svg>\n"
    }
}

fn law() -> AreaLaw {
    let pressure_pa: Vec<f64> = (2..=1000).map(|step| 0.02e6 * f64::from(step)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| persson_area_fraction(*p, SCALE_PA, 1.0).unwrap()).collect();
    AreaLaw::from_area_curve(&pressure_pa, &area, THRESHOLD_PA).unwrap()
}

fn groove(width_um: f64, spacing_um: f64, depth_um: f64) -> Pattern {
    Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap()
}

/// Scene of a groove in polyethylene, in a layer of `height_um` with blocks of `block_um`.
fn scene(pattern: Pattern, height_um: f64, block_um: f64, run: RunOptions) -> Scene {
    let [height_m, block_m] = [height_um, block_um].map(|length| length * 1e-6);
    Scene {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law: Some(law()),
        pattern: Some(pattern),
        relief: None,
        layer: Layer { length_m: pattern.pitch_m(), height_m, block_m, thickness_m: None, holder: None },
        loads: vec![Load { pressure_pa: PRESSURE_PA, friction: LocalFriction::new(0.30, 0.27, 0.05).unwrap() }],
        speed_m_s: 2e-3,
        run,
    }
}

/// Positions of contact blocks in micrometres, and their pressures in megapascals.
fn pressures(pattern: Pattern, height_um: f64, block_um: f64) -> Vec<[f64; 2]> {
    let scene = scene(pattern, height_um, block_um, RunOptions::default());
    let found = SteadyCell::new(&scene).solve(&pattern).remove(0).surface.interface;
    found.iter().map(|point| [point.x_m * 1e6, point.pressure_pa * 1e-6]).collect()
}

/// A cell of 12 x 5 blocks with its springs, and the pressure on each contact block.
fn lattice() -> String {
    const COLUMNS: i32 = 12;
    const ROWS: i32 = 5;
    let pattern = groove(40.0, 80.0, 20.0);
    let mut drawing = Drawing::new(
        "A cell of blocks and springs, and the pressure on its contact blocks",
        [[-0.5, f64::from(COLUMNS) - 0.5], [-1.1, f64::from(ROWS) + 0.2]],
    );
    let is_there = |i: i32, j: i32| (0..COLUMNS).contains(&i) && j >= 0 && (j > 1 || !(4..8).contains(&i));
    let place = |i: i32, j: i32| [f64::from(i), f64::from(j)];
    let blocks: Vec<(i32, i32)> =
        (0..=ROWS).flat_map(|j| (0..COLUMNS).map(move |i| (i, j))).filter(|(i, j)| is_there(*i, *j)).collect();
    for &(i, j) in &blocks {
        for (di, dj) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
            let is_bulk = j == ROWS || j + dj > ROWS;
            if is_there(i + di, j + dj) && !is_bulk {
                drawing.line(&[place(i, j), place(i + di, j + dj)], GREY, if di * dj == 0 { 1.6 } else { 0.9 });
            }
        }
    }
    let bulk = f64::from(ROWS);
    drawing.area(&[[-0.5, bulk - 0.15], [11.5, bulk - 0.15], [11.5, bulk + 0.2], [-0.5, bulk + 0.2]], GREY, 0.5);
    for &(i, j) in blocks.iter().filter(|(_, j)| *j < ROWS) {
        drawing.dot(place(i, j), if j == 0 { BLUE } else { INK });
    }
    for [x_um, pressure_mpa] in pressures(pattern, 50.0, 10.0) {
        let x = x_um / 10.0 - 0.5;
        let foot = -0.25 - 0.2 * pressure_mpa;
        drawing.line(&[[x, -0.25], [x, foot]], RED, 2.0);
        drawing.line(&[[x - 0.07, -0.42], [x, -0.25], [x + 0.07, -0.42]], RED, 2.0);
    }
    drawing.label([5.5, 0.4], "cavity", "middle", GREY);
    drawing.end()
}

/// Pressure beside a groove in blocks of three sizes.
fn edge_pressure() -> String {
    let pattern = groove(130.0, 370.0, 20.0);
    let series = [("blocks of 10 µm", 10.0), ("5 µm", 5.0), ("2.5 µm", 2.5)].map(|(label, block_um)| {
        let left_um = (185.0_f64 / block_um).floor() * block_um;
        let points = pressures(pattern, 200.0, block_um).into_iter().map(|[x_um, mpa]| [x_um - left_um, mpa]).collect();
        charts::Series { label, points }
    });
    let title = "Pressure beside a groove of 130 µm at 2.6 MPa";
    charts::interface_pressure(title, &series, &[[0.0, 130.0]], PRESSURE_PA * 1e-6).unwrap()
}

/// Real contact area and f by Persson's theory.
fn area_law() -> String {
    let area = |mpa: f64| persson_area_fraction(mpa * 1e6, SCALE_PA, 1.0).unwrap();
    let point = |step: u32| {
        let pressure_mpa = 0.04 * 10_f64.powf(0.05 * f64::from(step));
        let factor = law().factor(pressure_mpa * 1e6);
        charts::AreaPoint { pressure_mpa, area_fraction: area(pressure_mpa), factor, ..Default::default() }
    };
    let threshold_mpa = THRESHOLD_PA * 1e-6;
    let title = "Area law by Persson's theory, E* h'rms = 4 MPa";
    let points: Vec<charts::AreaPoint> = (0..=48).map(point).collect();
    charts::area_law(title, &points, Some([threshold_mpa, area(threshold_mpa)]), &[]).unwrap()
}

/// Friction of one cell from rest.
fn stick_slip() -> String {
    let run = RunOptions { fidelity: Fidelity::Dynamic, sliding_m: 1.2e-6, ..RunOptions::default() };
    let found = simulate(&scene(groove(130.0, 370.0, 20.0), 100.0, 10.0, run), &Unwatched).unwrap().loads.remove(0);
    let traces = [trace("flat", &found.flat.unwrap(), None), trace("grooves", &found.surface, None)];
    let title = "Friction of one cell from rest at 2.6 MPa";
    charts::friction_trace(title, &traces, "dynamic friction").unwrap()
}

/// Load of the pictures of the discrepancy.
const AT: At = At { pressure_pa: 1.5e6, speed_m_s: 2e-3, humidity: 0.4 };

/// Discrepancy before any trial, or after grooves of 100/300/10 µm whose friction is 15 % below the model.
fn discrepancy(is_tried: bool) -> Discrepancy {
    let measured = Measured {
        load: AT,
        measured: 0.85,
        modelled: 1.0,
        patterned_std: 0.01,
        flat_std: 0.01,
        sensitivity: Sensitivity::default(),
    };
    let trial = Trial {
        name: "T1".to_owned(),
        features: Features::from(&groove(100.0, 300.0, 10.0)),
        sample_std: None,
        disc: None,
        measured: vec![measured],
        dimensions_std_m: [0.0; 3],
        dimension_shifts: Vec::new(),
    };
    let trials = if is_tried { vec![trial] } else { Vec::new() };
    Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.1, trials).unwrap()
}

/// Quantile `p` of the measured over the modelled ratio of grooves of 100 µm with the areal density `share`.
fn excess(known: &Discrepancy, share: f64, p: f64) -> f64 {
    let features = Features::from(&groove(100.0, 100.0 / share - 100.0, 10.0));
    known.at(&[AT]).predict(&features, &[Sensitivity::default()]).quantile(0, p).exp()
}

/// Prior and posterior of the discrepancy against areal density.
fn forms() -> String {
    let mut drawing =
        Drawing::new("What one trial says about other densities (median and 95 %)", [[0.0, 50.0], [0.2, 2.0]]);
    let shares: Vec<f64> = (1..=50).map(f64::from).collect();
    for (known, color, opacity) in [(discrepancy(false), GREY, 0.2), (discrepancy(true), BLUE, 0.25)] {
        let line = |p: f64| -> Vec<[f64; 2]> {
            shares.iter().map(|pct| [*pct, excess(&known, pct / 100.0, p).clamp(0.2, 2.0)]).collect()
        };
        let band: Vec<[f64; 2]> = line(0.025).into_iter().chain(line(0.975).into_iter().rev()).collect();
        drawing.area(&band, color, opacity);
        drawing.line(&line(0.5), color, 2.5);
    }
    drawing.dot([25.0, 0.85], RED);
    drawing.label([26.0, 0.9], "trial", "start", RED);
    drawing.label([12.0, 1.6], "before any trial", "start", GREY);
    drawing.label([36.0, 0.45], "after the trial", "start", BLUE);
    drawing.axes([10.0, 0.2], ["areal density (%)", "measured over modelled ratio"]);
    drawing.end()
}

/// Distribution of a sample's ratio, and the part of it within the accepted band.
fn chance() -> String {
    const BAND: [f64; 2] = [0.66, 0.74];
    const RANGE: [f64; 2] = [0.5, 0.9];
    let pattern = groove(100.0, 250.0, 10.0);
    let modelled =
        SteadyCell::new(&scene(pattern, 200.0, 10.0, RunOptions::default())).solve(&pattern)[0].ratio.unwrap();
    let known = discrepancy(true).at(&[AT]).predict(&Features::from(&pattern), &[Sensitivity::default()]);
    let below = |ratio: f64| known.probability_below(0, (ratio / modelled).ln());
    let density = |ratio: f64| [ratio, (below(ratio + 0.001) - below(ratio - 0.001)) / 0.002];
    let between = |from: f64, to: f64| -> Vec<[f64; 2]> {
        (0..=200).map(|step| density(from + (to - from) * f64::from(step) / 200.0)).collect()
    };
    let high = between(RANGE[0], RANGE[1]).iter().map(|point| point[1]).fold(0.0, f64::max);
    let mut drawing =
        Drawing::new("The chance is the part of the distribution within the band", [RANGE, [0.0, 1.15 * high]]);
    let mut part = between(BAND[0], BAND[1]);
    part.extend([[BAND[1], 0.0], [BAND[0], 0.0]]);
    drawing.area(&part, GREEN, 0.35);
    for edge in BAND {
        drawing.line(&[[edge, 0.0], [edge, 1.1 * high]], GREEN, 1.6);
    }
    drawing.line(&between(RANGE[0], RANGE[1]), BLUE, 2.5);
    drawing.line(&[[modelled, 0.0], [modelled, 0.5 * high]], GREY, 2.0);
    drawing.label([modelled + 0.005, 0.45 * high], "model alone", "start", GREY);
    let chance = 100.0 * (below(BAND[1]) - below(BAND[0]));
    drawing.label([BAND[0] + 0.017, 0.2 * high], &format!("{chance:.0} %"), "middle", INK);
    drawing.axes([0.1, 2.0 * high], ["ratio of a cut sample", "probability density"]);
    drawing.end()
}

/// Picture of a chapter: name of the chapter, name of the picture, and function that draws it.
type Picture = (&'static str, &'static str, fn() -> String);

#[test]
fn pictures_of_the_theory_are_drawn_by_the_program() {
    let pictures: [Picture; 6] = [
        ("lattice", "lattice", lattice),
        ("steady", "edge-pressure", edge_pressure),
        ("friction", "area-law", area_law),
        ("dynamic", "stick-slip", stick_slip),
        ("trials", "forms", forms),
        ("uncertainty", "chance", chance),
    ];
    for (chapter, name, draw) in pictures {
        let shown = text(&book().join(format!("theory/{chapter}.md")));
        assert!(shown.contains(&format!("src=\"../pictures/theory/{name}.svg\"")), "{chapter}: {name}");
        keep(&book().join(format!("pictures/theory/{name}.svg")), &draw());
    }
}
