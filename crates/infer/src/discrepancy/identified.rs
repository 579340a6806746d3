//! Identification: whether the trials distinguish the forms.

use slipgrid_base::statistics::extremes;

use crate::discrepancy::{Discrepancy, Features, Form};

/// Minimum posterior weight of a family of forms that counts as identified.
const IDENTIFIED: f64 = 0.8;
/// Minimum difference of the logarithms of a feature at which two textures differ, and of the logarithms of two forms'
/// growth at which the forms differ. The amplitude of a form at one texture is known to a few hundredths at best.
const APART: f64 = 0.1;

impl Discrepancy {
    /// Returns the identified family of forms; `None` if the trials do not identify one.
    ///
    /// At a single texture the amplitude of every form can be fitted, so the weights differ only by the prior
    /// amplitudes there. A family with the form h_k is therefore identified only if, for every form h_j of another
    /// family, two trials with the textures x1 and x2 differ in h_k relative to h_j:
    ///
    /// ```text
    /// |ln(h_k(x1) / h_k(x2)) - ln(h_j(x1) / h_j(x2))| > 0.1
    /// ```
    ///
    /// The form without an effect differs from every other form already at a single texture.
    pub fn identified(&self) -> Option<&'static str> {
        let forms = self.forms();
        let share =
            |family: &str| -> f64 { forms.iter().filter(|of| of.form.family() == family).map(|of| of.weight).sum() };
        let family = forms.iter().map(|of| of.form.family()).find(|family| share(family) > IDENTIFIED)?;
        let own = forms.iter().filter(|of| of.form.family() == family);
        let own = own.max_by(|a, b| a.weight.total_cmp(&b.weight))?;
        let mut others = forms.iter().filter(|of| of.form.family() != family && of.prior > 0.0).map(|of| of.form);
        let are_apart = |one: Form, other: Form| {
            let growth = |of: &Features| libm::log(one.value(of) / other.value(of));
            [one, other].contains(&Form::None) || self.range(&growth) > APART
        };
        others.all(|other| are_apart(own.form, other)).then_some(family)
    }

    /// Whether all trials have one texture, by areal density, edge length and depth.
    pub fn has_one_texture(&self) -> bool {
        let features: [fn(&Features) -> f64; 3] = [|of| of.areal_density, |of| of.edge_1_m, |of| of.depth_m];
        !self.trials().is_empty() && features.iter().all(|of| self.range(&|own| libm::log(of(own))) <= APART)
    }

    /// Maximum minus minimum of the finite values of `log` at the features of the trials.
    fn range(&self, log: &dyn Fn(&Features) -> f64) -> f64 {
        let logs = self.trials().iter().map(|trial| log(&trial.features)).filter(|log| log.is_finite());
        let [least, most] = extremes(logs);
        most - least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrepancy::tests::{cut, groove, measured};
    use crate::discrepancy::{Conditions, Hyperparameters, Load, Sensitivity, Trial};

    /// Discrepancy learned from grooves of these widths, spacings and depths, in um, that grows with edge length.
    fn learned(textures: &[[f64; 3]]) -> Discrepancy {
        let load = Load { pressure_pa: 1e6, speed_m_s: 2e-3, humidity: 0.4 };
        let trial = |&[width_um, spacing_um, depth_um]: &[f64; 3]| -> Trial {
            let features = groove(width_um, spacing_um, depth_um);
            let log = -0.1 * features.edge_1_m / 2080.0;
            cut("", features, vec![measured(load, log, 0.005, Sensitivity::default())])
        };
        let trials = textures.iter().map(trial).collect();
        Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.0, trials).unwrap()
    }

    #[test]
    fn a_form_is_named_only_where_textures_tell_it_from_the_others() {
        // A dense texture with repeats: some forms lose weight because their prior amplitudes there were too large.
        let one = learned(&[[84.0, 31.0, 48.0], [84.0, 30.0, 48.0], [83.0, 31.0, 48.0]]);
        assert!(one.has_one_texture() && one.identified().is_none(), "{:?}", one.forms());
        let many =
            [[100.0, 400.0, 10.0], [30.0, 120.0, 2.0], [300.0, 700.0, 20.0], [50.0, 500.0, 3.0], [40.0, 60.0, 20.0]];
        let found = learned(&many);
        assert!(!found.has_one_texture());
        assert_eq!(found.identified(), Some("edge length"), "{:?}", found.forms());
        // Edges in proportion to the density: the two forms cannot be distinguished.
        let alike = learned(&[[100.0, 100.0, 10.0], [100.0, 300.0, 10.0], [100.0, 900.0, 10.0]]);
        assert!(!alike.has_one_texture() && alike.identified().is_none(), "{:?}", alike.forms());
        assert!(!learned(&[]).has_one_texture());
        // The first is similar to both others, which differ from each other; the order must not matter.
        let [middle, shallow, deep] = [48.0, 44.5, 52.0].map(|depth_um| [84.0, 31.0, depth_um]);
        for textures in [[middle, shallow, deep], [shallow, middle, deep], [deep, shallow, middle]] {
            assert!(!learned(&textures).has_one_texture());
        }
    }
}
