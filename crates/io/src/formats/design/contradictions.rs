//! Contradictions between a design and its calibration or material, and speeds that no run in time can confirm.

use slipgrid_base::units::{LENGTH_MM, tidy};

use super::Design;
use crate::formats::calibration::Calibration;
use crate::formats::diagnostic::Diagnostic;
use crate::formats::unusual::too_fast;

/// Relative difference below which two thicknesses are equal.
const SAME_THICKNESS: f64 = 0.01;

impl Design {
    /// Statements about the specimen in which the design contradicts `calibration`, the source of its material.
    pub fn contradictions(&self, calibration: &Calibration) -> Vec<Diagnostic> {
        self.thickness(calibration).into_iter().chain(self.holder(calibration)).collect()
    }

    /// Diagnostics that need the material: pressures that strain the material too much, a speed that no run in time can
    /// confirm, and trials that were modelled on another specimen.
    pub fn material_told(&self) -> Vec<Diagnostic> {
        self.strained().into_iter().chain(self.too_fast()).chain(self.layer_alone()).collect()
    }

    /// Diagnostic if the design models a layer alone, while the trials of its material file were modelled on a whole
    /// specimen, whose ratios differ by up to some hundredths; otherwise `None`. A calibration models its trials again.
    fn layer_alone(&self) -> Option<Diagnostic> {
        let learned = self.task.material.as_ref()?.uncertainty.learned.as_ref()?;
        if self.calibration.is_some() || self.task.layer.thickness_m.is_some() || learned.trials().is_empty() {
            return None;
        }
        let reason = "um is modelled alone, and the trials of the material on a whole specimen";
        let told = self.document.refuse_or_default(("sample", "layer_um"), None, reason.to_owned());
        Some(
            told.expected("thickness_mm beside it, or the calibration file as material, which models its trials again"),
        )
    }

    /// Diagnostic if the design models another thickness than `calibration` states; otherwise `None`.
    fn thickness(&self, calibration: &Calibration) -> Option<Diagnostic> {
        let (stated_m, own_m) = (calibration.thickness_m?, self.task.layer.thickness_m?);
        if (own_m / stated_m - 1.0).abs() < SAME_THICKNESS {
            return None;
        }
        let [stated_mm, own_mm] = [stated_m, own_m].map(|length_m| tidy(LENGTH_MM.from_si(length_m)));
        let key = ("sample", "thickness_mm");
        let own = match self.document.place(key.0, key.1) {
            Some(_) => "mm is the thickness here".to_owned(),
            None => format!("is not given, so that {own_mm} mm is taken"),
        };
        let reason = format!("{own}, and the specimen of the calibration is {stated_mm} mm thick");
        let told = self.document.refuse_or_default(key, None, reason);
        Some(told.expected(format!("thickness_mm = {stated_mm} in [sample], if the design is for the same specimen")))
    }

    /// Diagnostic if the design models another holder than `calibration` states; otherwise `None`. Without a thickness,
    /// a holder has no effect.
    fn holder(&self, calibration: &Calibration) -> Option<Diagnostic> {
        let (stated, own) = (calibration.holder?, self.task.layer.holder);
        if self.task.layer.thickness_m.is_none() || own == Some(stated) {
            return None;
        }
        let own = own.map_or("is not given", |_| "is the holder here");
        let reason = format!("{own}, and the holder of the calibration's specimen is \"{}\"", stated.name());
        let told = self.document.refuse_or_default(("sample", "holder"), None, reason);
        Some(told.expected(format!(
            "holder = \"{}\" beside thickness_mm in [sample], if the design is for a specimen that is held so",
            stated.name()
        )))
    }

    /// Diagnostic if the speed is so high at the lowest pressure that no dynamic run (run in time) represents it;
    /// otherwise `None`.
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
