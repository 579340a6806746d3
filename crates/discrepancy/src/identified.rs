//! Whether the trials tell the forms apart.

use crate::{Discrepancy, Features, Form};

/// A family of forms with more weight than this is what the trials say.
const IDENTIFIED: f64 = 0.8;
/// Difference of logarithms from which on two textures differ, and two forms grow differently from one to the other. A form's amplitude at
/// one texture is known to a few hundredths at best.
const APART: f64 = 0.1;

impl Discrepancy {
    /// The family of forms that the trials say; `None` while they do not.
    ///
    /// One texture gives every form an amplitude that fits: weights then differ by nothing but how large each was believed to be
    /// there. So a family is named only where two trials at least lie apart in its form and in every form of another family,
    ///
    /// ```text
    /// |ln(h_k(x1) / h_k(x2)) - ln(h_j(x1) / h_j(x2))| > 0.1
    /// ```
    #[must_use]
    pub fn identified(&self) -> Option<&'static str> {
        let forms = self.forms();
        let share =
            |family: &str| -> f64 { forms.iter().filter(|of| of.form.family() == family).map(|of| of.weight).sum() };
        let family = forms.iter().map(|of| of.form.family()).find(|family| share(family) > IDENTIFIED)?;
        let own = forms.iter().filter(|of| of.form.family() == family);
        let own = own.max_by(|a, b| a.weight.total_cmp(&b.weight))?;
        let mut others = forms.iter().filter(|of| of.form.family() != family && of.prior > 0.0);
        others.all(|other| self.tell_apart(&own.form, &other.form)).then_some(family)
    }

    /// Whether all trials are of one texture: alike in areal density, in edge length and in depth.
    #[must_use]
    pub fn has_one_texture(&self) -> bool {
        let Some((first, others)) = self.trials().split_first() else { return false };
        others.iter().all(|other| is_alike(&first.features, &other.features))
    }

    /// Whether one of two forms grows otherwise than the other from one of the trials to another.
    fn tell_apart(&self, one: &Form, other: &Form) -> bool {
        let log = |of: &Features| libm::log(one.value(of) / other.value(of));
        let logs = || self.trials().iter().map(|trial| log(&trial.features)).filter(|log| log.is_finite());
        let (least, most) = (logs().fold(f64::INFINITY, f64::min), logs().fold(f64::NEG_INFINITY, f64::max));
        most - least > APART
    }
}

fn is_alike(one: &Features, other: &Features) -> bool {
    let of = |of: &Features| [of.areal_density, of.edge_1_m, of.depth_m];
    of(one).iter().zip(of(other)).all(|(one, other)| libm::log(one / other).abs() <= APART)
}
