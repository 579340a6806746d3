//! Predictions of textures by the table, and of samples that differ from a known texture.

use slipgrid_infer::discrepancy::{Features, Measured, Sensitivity, Trial};
use slipgrid_laser::specimen::Laid;
use slipgrid_model::pattern::Pattern;

use super::Search;
use crate::as_cut::CutTexture;
use crate::evaluation_cache::Answer;
use crate::prediction::Prediction;

impl Search<'_> {
    /// Interpolates `pattern` in the table; `None` next to a node that the model cannot compute, if cavities close
    /// under load, or if the specimen does not take `pattern`.
    pub fn interpolated(&self, pattern: &Pattern) -> Option<CutTexture> {
        self.interpolated_with(pattern, &self.table.lay(pattern)?, 1.0)
    }

    /// Like [`Self::interpolated`], laid out as in `laid`, with `peak` times the peak pressure of the cell.
    pub(super) fn interpolated_with(&self, pattern: &Pattern, laid: &Laid, peak: f64) -> Option<CutTexture> {
        let (texture, answer) = self.unlimited(pattern, laid)?;
        let answer = Answer { peak_pressure_mpa: peak * answer.peak_pressure_mpa, ..answer };
        self.limited(texture, answer).ok()
    }

    /// Interpolates `pattern` in the table, laid out as in `laid`, and what the limits are compared with.
    fn unlimited(&self, pattern: &Pattern, laid: &Laid) -> Option<(CutTexture, Answer)> {
        let (modelled, answer) = self.table.at(pattern, laid)?;
        let shifts = self.table.dimension_shifts(pattern, laid, &self.task.tolerances.unwrap_or_default())?;
        let texture = CutTexture::interpolated(*pattern, modelled, shifts);
        let by_face = self.table.by_face(pattern, &texture.ratio);
        Some((texture.moved(&self.table.by_blocks(pattern)).moved(&by_face), answer))
    }

    /// Predicts `pattern` by the table alone; `None` as for [`Self::interpolated`].
    pub fn roughly(&self, pattern: &Pattern) -> Option<Prediction> {
        self.interpolated(pattern).map(|texture| self.predicted(texture))
    }

    /// Predicts `pattern` for a lattice by the table, laid out as in `laid`, with the correction `off` of ln R at each
    /// load, the covariance of ln R from shared errors, and `peak` times the peak pressure.
    pub fn roughly_with(
        &self,
        (pattern, laid): (&Pattern, &Laid),
        off: &[f64],
        covariance: &[f64],
        peak: f64,
    ) -> Option<Prediction> {
        Some(self.on_lattice(self.interpolated_with(pattern, laid, peak)?, off, covariance))
    }

    /// Like [`Self::roughly_with`], without a comparison with the limits.
    pub fn roughly_unlimited(
        &self,
        (pattern, laid): (&Pattern, &Laid),
        off: &[f64],
        covariance: &[f64],
    ) -> Option<Prediction> {
        Some(self.on_lattice(self.unlimited(pattern, laid)?.0, off, covariance))
    }

    fn on_lattice(&self, texture: CutTexture, off: &[f64], covariance: &[f64]) -> Prediction {
        let texture = CutTexture { covariance: covariance.to_vec(), ..texture.moved(off) };
        Prediction::new(texture, &self.of_lattices, self.asked)
    }

    /// Error of the table in ln R at each load for the texture of `found`; empty if the table has no value.
    pub fn off_at(&self, found: &Prediction) -> Vec<f64> {
        let table = self.interpolated(&found.texture.pattern);
        let ratios = table.iter().flat_map(|table| found.texture.ratio.iter().zip(&table.ratio));
        ratios.map(|(exact, table)| (exact / table).ln()).collect()
    }

    /// Predicts a sample of `found` that has the dimensions of `made`: the ratio changes as the model computes, and the
    /// discrepancy is that of `made`. `None` unless the model can compute both.
    pub fn made(&self, found: &Prediction, made: &Pattern) -> Option<Prediction> {
        let model = self.models.own;
        let laid = model.lay(&found.texture.pattern).ok()?;
        let [made_ratio, designed] =
            [made, &found.texture.pattern].map(|pattern| model.ratios_made(pattern, &laid).ok());
        let by: Vec<f64> = made_ratio?.iter().zip(designed?).map(|(made, designed)| (made / designed).ln()).collect();
        let designed = &found.texture.features;
        let features = Features::on_face(made, laid.share(made));
        let shifts = found.texture.dimension_shifts.iter().map(|shift| shift.about(designed, &features));
        let texture = CutTexture { features, dimension_shifts: shifts.collect(), ..found.texture.clone() };
        Some(self.predicted(texture.moved(&by)))
    }

    /// Chance that another sample of `trial` is on target: its modelled ratios, with the errors of the inputs of the
    /// texture `like`. `None` if it was not measured at a load. The texture of a sector is solved on the whole specimen.
    pub fn another_of(&self, trial: &Trial, like: &Prediction) -> Option<f64> {
        if trial.disc.is_some() && self.beyond.face.is_some() {
            let solved = self.solved(&self.pattern_of(&trial.features)?).ok()?;
            return Some(self.as_cut(&solved).chance());
        }
        let at = |value: fn(&Measured) -> f64| self.asked.at_loads(trial, value);
        let moduli = at(|at| at.sensitivity.modulus)?.into_iter();
        let sensitivity = moduli.zip(at(|at| at.sensitivity.local_law)?);
        let shifts =
            like.texture.dimension_shifts.iter().map(|shift| shift.about(&like.texture.features, &trial.features));
        let texture = CutTexture {
            features: trial.features,
            ratio: at(|at| at.modelled)?,
            sensitivity: sensitivity.map(|(modulus, local_law)| Sensitivity { modulus, local_law }).collect(),
            dimension_shifts: shifts.collect(),
            ..like.texture.clone()
        };
        Some(self.predicted(texture).chance())
    }
}
