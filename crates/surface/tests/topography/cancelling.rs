//! Operations on maps end at any point at which their monitor cancels.

use std::sync::atomic::{AtomicUsize, Ordering};

use slipgrid_base::monitor::{Monitor, Unwatched};
use slipgrid_surface::topography::{
    CutPattern, CutShape, Form, HeightMap, MapError, MapFormat, Preparation, PreparationError, PreparedMap, ReadMap,
    SelfAffine,
};

/// A monitor that cancels after `after` checks.
struct Patient {
    after: usize,
    asked: AtomicUsize,
}

impl Patient {
    const fn new(after: usize) -> Self {
        Self { after, asked: AtomicUsize::new(0) }
    }
}

impl Monitor for Patient {
    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.after
    }
}

/// A patterned map with missing points.
fn map() -> HeightMap {
    let mut map = SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
    let pixel_m = map.dx_m();
    let pattern = CutPattern {
        shape: CutShape::Square,
        width_m: 8.0 * pixel_m,
        spacing_m: 12.0 * pixel_m,
        depth_m: 5e-6,
        wall_m: 0.0,
        width_std_m: 0.0,
        pitch_std_m: 0.0,
        depth_std_m: 0.0,
        rim: None,
        seed: 1,
    };
    map.cut_cavities(&pattern).unwrap();
    let heights = map.heights_m().iter().enumerate().map(|(n, &height)| if n % 97 == 5 { f64::NAN } else { height });
    HeightMap::new(64, 64, pixel_m, pixel_m, heights.collect()).unwrap()
}

#[test]
fn every_work_on_a_map_ends_wherever_it_is_cancelled() {
    let map = map();
    let read = || {
        let map = map.clone();
        ReadMap { map, whole: true, format: MapFormat::Matrix, comments: Vec::new(), notes: Vec::new() }
    };
    let of_map = |error| match error {
        PreparationError::Map(error) => error,
        other => panic!("{other}"),
    };
    let how = Preparation { despike: true, ..Preparation::default() };
    type Work<'a> = Box<dyn Fn(&dyn Monitor) -> Result<(), MapError> + 'a>;
    let works: [(&str, Work<'_>); 4] = [
        ("cavities", Box::new(|monitor| map.measure_cavities(Form::Plane, monitor).map(|_| ()))),
        ("mean period", Box::new(|monitor| map.mean_cavity_period(Form::Plane, monitor).map(|_| ()))),
        ("preparing", Box::new(|monitor| PreparedMap::new(read(), how, monitor).map(|_| ()).map_err(of_map))),
        ("one period", Box::new(|monitor| PreparedMap::one_period(read(), how, monitor).map(|_| ()).map_err(of_map))),
    ];
    for (name, work) in works {
        let whole = Patient::new(usize::MAX);
        assert_eq!((work(&whole), work(&Unwatched)), (Ok(()), Ok(())), "{name}");
        let asked = whole.asked.into_inner();
        assert!(asked > 6, "{name} asks {asked} times");
        // Ten of all questions, and each of the last ten, after which no other would end the work.
        for after in (0..asked).step_by(asked.div_ceil(10)).chain(asked.saturating_sub(10)..asked) {
            assert_eq!(
                work(&Patient::new(after)),
                Err(MapError::Cancelled),
                "{name}, cancelled after {after} of {asked}"
            );
        }
    }
}
