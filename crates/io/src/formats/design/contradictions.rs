//! Contradictions between a design and its calibration or material, and speeds that no run in time can confirm.

use std::ops::Range;

use slipgrid_base::units::{LENGTH_MM, LENGTH_UM, significant, tidy};

use super::Design;
use crate::formats::calibration::Calibration;
use crate::formats::diagnostic::Diagnostic;
use crate::formats::unusual::too_fast;

/// Relative difference below which two thicknesses are equal.
const SAME_THICKNESS: f64 = 0.01;
/// A dimension of a trial is reported if it lies outside the bounds of the design by this factor.
const FAR_OUTSIDE: f64 = 3.0;

impl Design {
    /// Statements about the specimen in which the design contradicts `calibration`, the source of its material.
    #[must_use]
    pub fn contradictions(&self, calibration: &Calibration) -> Vec<Diagnostic> {
        let samples = &calibration.trials.samples;
        let cut = samples.iter().map(|cut| {
            let pattern = &cut.pattern;
            (cut.name.as_str(), [pattern.width_m(), pattern.spacing_m(), pattern.depth_m()])
        });
        let outside = cut.filter_map(|(name, lengths_m)| self.outside(name, lengths_m));
        self.thickness(calibration).into_iter().chain(self.holder(calibration)).chain(outside).collect()
    }

    /// Diagnostics that need the material: a speed that no run in time can confirm, and trials far outside the bounds.
    #[must_use]
    pub fn material_told(&self) -> Vec<Diagnostic> {
        let known = self.task.material.as_ref().filter(|_| self.calibration.is_none());
        let learned = known.and_then(|known| known.uncertainty.learned.as_ref());
        let trials = learned.map_or(&[][..], |learned| learned.trials());
        let outside = trials.iter().filter_map(|trial| {
            let of = &trial.features;
            self.outside(&trial.name, [of.width_m, of.pitch_m - of.width_m, of.depth_m])
        });
        self.strained().into_iter().chain(self.too_fast()).chain(outside).collect()
    }

    /// Thickness that the calibration states, if the design models another.
    fn thickness(&self, calibration: &Calibration) -> Option<Diagnostic> {
        let (stated_m, own_m) = (calibration.thickness_m?, self.task.layer.thickness_m?);
        if (own_m / stated_m - 1.0).abs() < SAME_THICKNESS {
            return None;
        }
        let [stated_mm, own_mm] = [stated_m, own_m].map(|length_m| tidy(LENGTH_MM.from_si(length_m)));
        let own = match self.places.thickness {
            Some(_) => "mm is the thickness here".to_owned(),
            None => format!("is not given, so that {own_mm} mm is taken"),
        };
        let reason = format!("{own}, and the specimen of the calibration is {stated_mm} mm thick");
        let told = self.refuse_sample_key(&self.places.thickness, "sample.thickness_mm", reason);
        Some(told.expected(format!("thickness_mm = {stated_mm} in [sample], if the design is for the same specimen")))
    }

    /// Holder that the calibration states, if the design models another. Without a thickness no holder has an effect.
    fn holder(&self, calibration: &Calibration) -> Option<Diagnostic> {
        let (stated, own) = (calibration.holder?, self.task.layer.holder);
        if self.task.layer.thickness_m.is_none() || own == Some(stated) {
            return None;
        }
        let own = own.map_or("is not given", |_| "is the holder here");
        let reason = format!("{own}, and the holder of the calibration's specimen is \"{}\"", stated.name());
        let told = self.refuse_sample_key(&self.places.holder, "sample.holder", reason);
        Some(told.expected(format!(
            "holder = \"{}\" beside thickness_mm in [sample], if the design is for a specimen that is held so",
            stated.name()
        )))
    }

    /// Refuses the value at `place`, or `key` by name if the design does not state it.
    fn refuse_sample_key(&self, place: &Option<Range<usize>>, key: &str, reason: String) -> Diagnostic {
        match place {
            Some(place) => self.document.refuse(place.clone(), reason),
            None => Diagnostic { key: Some(key.into()), ..Diagnostic::file(self.document.path(), reason) },
        }
    }

    /// First dimension of the trial `name` that lies far outside the bounds of the design; or width and spacing, if
    /// each lies within the bounds of the other.
    fn outside(&self, name: &str, lengths_m: [f64; 3]) -> Option<Diagnostic> {
        let bounds_m = self.task.space.lengths_m();
        let within = |length_m: f64, [from_m, to_m]: [f64; 2]| length_m >= from_m && length_m <= to_m;
        let [width_m, spacing_m, _] = lengths_m;
        let um = |length_m: f64| tidy(significant(LENGTH_UM.from_si(length_m), 4));
        let path = self.calibration.as_deref().unwrap_or(self.document.path());
        let told = |key: &str, reason: String| Diagnostic {
            key: Some(format!("trial.pattern.{key}").into()),
            ..Diagnostic::file(path, format!("of \"{name}\" {reason}"))
        };
        if !within(width_m, bounds_m[0])
            && !within(spacing_m, bounds_m[1])
            && within(width_m, bounds_m[1])
            && within(spacing_m, bounds_m[0])
        {
            let [width_um, spacing_um] = [width_m, spacing_m].map(um);
            let reason = format!(
                "is {width_um} um, and its spacing_um {spacing_um} um: the design's bounds hold them exchanged"
            );
            return Some(
                told("width_um", reason).expected("the width of a cavity, and the gap between two as spacing_um"),
            );
        }
        let keys = ["width_um", "spacing_um", "depth_um"];
        keys.into_iter().zip(lengths_m).zip(bounds_m).find_map(|((key, length_m), [from_m, to_m])| {
            let (times, end_m) =
                if length_m > to_m { (length_m / to_m, to_m) } else { (from_m / length_m, from_m) };
            (times > FAR_OUTSIDE).then(|| {
                let [more, end] = if length_m > to_m { ["more", "largest"] } else { ["less", "smallest"] };
                let reason = format!(
                    "is {} um, {} times {more} than the {end} of the design's bounds, {} um: the trial says little of such designs",
                    um(length_m),
                    significant(times, 2),
                    um(end_m)
                );
                told(key, reason).expected("the dimension as measured, with its decimal point in the right place")
            })
        })
    }

    /// Diagnostic if the speed is so high at the lowest pressure that no run in time represents it.
    fn too_fast(&self) -> Option<Diagnostic> {
        let elastic = &self.task.material.as_ref()?.material.elastic;
        let lightest_pa = self.task.pressures_pa().into_iter().reduce(f64::min)?;
        let of_conditions = self.task.also_at.iter().map(|condition| condition.speed_m_s);
        let speed_m_s = of_conditions.fold(self.task.speed_m_s, f64::max);
        let [reason, expected] = too_fast(elastic, lightest_pa, speed_m_s)?;
        let reason = format!("{reason}: no run in time confirms a design there");
        let told = Diagnostic { value: None, ..self.document.refuse(self.places.condition.clone(), reason) };
        Some(told.expected(expected))
    }
}
