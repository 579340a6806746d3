//! Checks that steps over a whole altitude map poll the monitor at least once every few rows.

use std::io::BufReader;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use slipgrid_base::monitor::{CancellableReader, Monitor, Unwatched};
use slipgrid_infer::calibrate::area_law::{AreaLawRequest, CONTACT_TOLERANCE, surface_area_law};
use slipgrid_model::pattern::RimProfile;
use slipgrid_report::surface::{Measured, SurfaceReport, files};
use slipgrid_surface::topography::{
    CutPattern, CutRim, CutShape, Form, HeightMap, LengthUnit, MaterialRatioCurve, MatrixStyle, Preparation,
    PreparedMap, ReadMap, ReadOptions, SelfAffine, Sides, read_map,
};

/// Monitor that counts polls, and cancels from the poll `cancels_at` on.
struct Polls {
    asked: AtomicUsize,
    cancels_at: usize,
}

impl Polls {
    const fn new(cancels_at: usize) -> Self {
        Self { asked: AtomicUsize::new(0), cancels_at }
    }

    fn asked(&self) -> usize {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Monitor for Polls {
    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) + 1 >= self.cancels_at
    }
}

/// Rough, tilted face with square cavities and rims, missing points, and spikes.
fn face(pixels: usize) -> HeightMap {
    let rough = SelfAffine { pixels, side_m: 2e-3, max_wave: 16, ..SelfAffine::STAND_IN };
    let mut map = rough.map().unwrap();
    let rim = CutRim { height_m: 1e-6, width_m: 40e-6, profile: RimProfile::Round, height_std_m: 0.0 };
    let pattern = CutPattern {
        shape: CutShape::Square,
        width_m: 130e-6,
        spacing_m: 260e-6,
        depth_m: 10e-6,
        wall_m: 10e-6,
        width_std_m: 0.0,
        pitch_std_m: 0.0,
        depth_std_m: 0.0,
        rim: Some(rim),
        seed: 1,
    };
    map.cut_cavities(&pattern).unwrap();
    let mut heights = map.heights_m().to_vec();
    for (n, height) in heights.iter_mut().enumerate() {
        let (i, j) = (n / pixels, n % pixels);
        let is_spike = i % 101 == 50 && j % 103 == 50;
        let is_hole = (i + j).is_multiple_of(11) || (i < pixels / 8 && j < pixels / 8);
        *height += 1e-9 * i as f64 + if is_spike { 20e-6 } else { 0.0 };
        *height = if is_hole { f64::NAN } else { *height };
    }
    HeightMap::new(pixels, pixels, map.dx_m(), map.dy_m(), heights).unwrap()
}

/// Map as a file, as read, and prepared for the steps of a measurement.
struct Made {
    text: String,
    read: ReadMap,
    measured: Measured,
    period: PreparedMap,
}

impl Made {
    fn new(pixels: usize) -> Self {
        let map = face(pixels);
        let style =
            MatrixStyle { channel: "z".into(), comments: Vec::new(), unit: LengthUnit::Micrometre, decimals: 4 };
        let text = map.to_matrix_text(&style);
        let read = read_map(text.as_bytes(), &ReadOptions::default()).unwrap();
        let surface = PreparedMap::new(read.clone(), Preparation::default(), &Unwatched).unwrap();
        let measured = Measured::new(surface, None, &Unwatched).unwrap();
        let rough = SelfAffine { pixels, max_wave: 16, ..SelfAffine::STAND_IN }.map().unwrap();
        let period =
            PreparedMap::one_period(ReadMap { map: rough, ..read.clone() }, Preparation::default(), &Unwatched);
        Self { text, read, measured, period: period.unwrap() }
    }
}

/// Step of measuring a map, which returns its error unless it was completed.
type Step = (&'static str, fn(&Made, &Polls) -> Option<String>);

fn error_of<T, E: std::fmt::Debug>(found: Result<T, E>) -> Option<String> {
    found.err().map(|error| format!("{error:?}"))
}

const STEPS: [Step; 10] = [
    ("reading", |made, monitor| {
        let source = BufReader::new(CancellableReader::new(made.text.as_bytes(), monitor));
        error_of(read_map(source, &ReadOptions::default()))
    }),
    ("preparation", |made, monitor| {
        let how = Preparation { form: Form::SecondOrder, despike: true, ..Preparation::default() };
        error_of(PreparedMap::new(made.read.clone(), how, monitor))
    }),
    ("one period", |made, monitor| {
        error_of(PreparedMap::one_period(made.read.clone(), Preparation::default(), monitor))
    }),
    ("cavities", |made, monitor| error_of(made.read.map.measure_cavities(Form::SecondOrder, monitor))),
    ("mean period", |made, monitor| error_of(made.read.map.mean_cavity_period(Form::Plane, monitor))),
    ("bearing curve", |made, monitor| error_of(MaterialRatioCurve::new(&made.measured.surface.map, monitor))),
    ("lengths", |made, monitor| error_of(made.measured.surface.map.correlation_lengths(Sides::Open, monitor))),
    ("report", |made, monitor| match SurfaceReport::new(Path::new("map"), &made.measured, monitor) {
        Ok(report) => error_of(files(&report, &made.measured, 0, monitor)),
        Err(error) => Some(format!("{error:?}")),
    }),
    ("spectrum", |made, monitor| error_of(made.measured.surface.map.radial_spectrum(Sides::Open, monitor))),
    ("area law", |made, monitor| {
        let request = AreaLawRequest {
            contact_modulus_pa: 0.43e9,
            pressures_pa: &[1e6],
            threshold_pa: 0.7e6,
            tolerance: CONTACT_TOLERANCE,
            windows: Some(2),
        };
        error_of(surface_area_law(&made.period, &request, monitor))
    }),
];

/// Number of points along a side of the map.
const PIXELS: usize = 256;
/// Maximum number of polls after cancelling: callers poll again on their way out.
const MAX_AFTER: usize = 64;

#[test]
fn a_step_over_a_map_asks_all_along_and_ends_wherever_it_is_cancelled() {
    let made = Made::new(PIXELS);
    for (name, step) in STEPS {
        let whole = Polls::new(usize::MAX);
        assert_eq!(step(&made, &whole), None, "{name}");
        let asked = whole.asked();
        assert!(asked >= PIXELS / 8, "{name}: {asked} questions");
        let shares = (1..8).map(|share| share * asked / 8);
        // Of the last questions each: after it no other would end the step.
        for cancels_at in [1, 2].into_iter().chain(shares).chain(asked - 9..=asked) {
            let polls = Polls::new(cancels_at);
            // A reader of a file has errors of its own.
            let is_cancelled =
                step(&made, &polls).is_some_and(|error| name == "reading" || error.contains("Cancelled"));
            assert!(is_cancelled, "{name}: went on after question {cancels_at} of {asked}");
            let after = polls.asked() - cancels_at;
            assert!(after <= MAX_AFTER, "{name}: asked {after} times after question {cancels_at} of {asked}");
        }
    }
}
