//! The chance by draws of the steady model itself.

use super::*;
use slipgrid_specimen::Laid;

/// The steady model itself at every draw, about values that are known, with some of the inputs off.
pub struct Sampled<'a> {
    chances: &'a Chances<'a>,
    about: About<'a>,
    /// The laser cuts the design's cavities: as many, each as large as drawn.
    laid: Laid,
    /// What ratios are multiplied by before they are compared with the target.
    scale: Vec<f64>,
    discrepancy: Option<Drawn>,
    of: &'a (dyn Fn(usize) -> bool + Sync),
}

impl<'a> Chances<'a> {
    /// Those of `draws` of the steady model in which every value is accepted; a draw that cannot be computed is one that is not. More
    /// draws begin with the same ones.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design or every draw cannot be computed.
    pub fn sampled(
        &self,
        about: &About<'_>,
        draws: usize,
        seed: u64,
        of: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<Accepted, ModelFailure> {
        let discrepancy = self.drawn(about.design)?;
        let factor = |load: usize| discrepancy.as_ref().map_or(1.0, |drawn| drawn.medians[load].exp());
        let scale = self.scale.iter().enumerate().map(|(load, scale)| scale * factor(load)).collect();
        let discrepancy = discrepancy.filter(|drawn| of(drawn.first));
        let laid = self.still.lay(about.design)?;
        let model = Sampled { chances: self, about: *about, laid, scale, discrepancy, of };
        let drawn = propagate(&model, about.design, &self.uncertainty, draws, seed)?;
        Ok(drawn.judged(|values| self.target.accepts(values)))
    }
}

impl UncertainModel for Sampled<'_> {
    fn respond_at(&self, made: &Pattern, deviations: &[f64]) -> Result<Vec<f64>, ModelFailure> {
        let (chances, about) = (self.chances, &self.about);
        let off = |place: usize| if (self.of)(place) { deviations[place - DIMENSIONS] } else { 0.0 };
        let length = |axis: usize, made_m: f64, own_m: f64| if (self.of)(axis) { made_m } else { own_m };
        let own = about.design;
        let has_rims_off = chances.uncertainty.rim().is_some_and(|place| (self.of)(place));
        let texture = if has_rims_off { made.texture() } else { own.texture() };
        let made = Pattern::new(
            texture.to_owned(),
            length(0, made.width_m(), own.width_m()),
            length(1, made.spacing_m(), own.spacing_m()),
            length(DEPTH, made.depth_m(), own.depth_m()),
        );
        let trial = |reason: String| ModelFailure::Trial { reason };
        let mut made = made.map_err(|error| trial(error.to_string()))?;
        if let Some(place) = chances.burst {
            made = by_deeper_bursts(&made, off(place))?;
        }
        let at = |along: &Option<Along>, load: usize| along.as_ref().map_or(0.0, |along| off(along.first + load));
        let input = |load: usize| load % chances.inputs_of_loads;
        let friction: Vec<f64> = (0..about.still.ratio.len()).map(|load| at(&chances.friction, input(load))).collect();
        let (scale, law) = (at(&chances.law_scale, 0), at(&chances.law, 0));
        let scale = ScaleShift::off_by(scale, chances.scale_is_fitted);
        let there = chances.still.beside(|scene: &Scene| moved(scene, &friction, scale, law));
        let ratio = there.map_err(|error| trial(error.to_string()))?.ratios_made(&made, &self.laid)?;
        let value = |load: usize| {
            let by = self.scale[load] * (ratio[load] - about.still.ratio[load]);
            let value = (about.values[load] + by) * if chances.is_ratio { 1.0 } else { 1.0 + friction[load] };
            value + about.numerical.off(load, |place| off(chances.first_numerical + place))
        };
        let values = (0..about.still.ratio.len()).map(value);
        let Some(drawn) = &self.discrepancy else { return Ok(values.collect()) };
        let all: Vec<f64> = (0..DIMENSIONS).map(|_| 0.0).chain(deviations.iter().copied()).collect();
        let (made_m, own_m) = (made.lengths_m(), own.lengths_m());
        let off_m = std::array::from_fn(|axis| made_m[axis] - own_m[axis]);
        Ok(values.zip(drawn.factors(&all, off_m)).map(|(value, factor)| value * factor).collect())
    }
}
