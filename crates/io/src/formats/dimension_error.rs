//! Standard errors of the measured dimensions of trials.

use super::values::Number;
use crate::formats::{Diagnostic, Document};
use slipgrid_base::units::{LENGTH_STD_UM, LENGTH_UM, significant};
use slipgrid_model::pattern::Pattern;

/// Maximum relative standard error of a dimension of a trial: with a larger error, little more is known than that a
/// cavity exists.
const MAX_RELATIVE_STD: f64 = 1.0 / 3.0;

/// Reads the standard errors of width, spacing and depth of the measured `pattern`, in metres, as its trial or its own
/// table states them, in this order in `stated`; 0 for an error that is not stated.
///
/// # Errors
/// [`Diagnostic`] if a number is out of range, or more than a third of the dimension, or if both tables state the error of
/// one dimension.
pub fn read(document: &Document, stated: &[[&Option<Number>; 3]], pattern: &Pattern) -> Result<[f64; 3], Diagnostic> {
    let mut stds_m = [0.0; 3];
    for (axis, (name, length_m)) in ["width", "spacing", "depth"].into_iter().zip(pattern.lengths_m()).enumerate() {
        let mut stated = stated.iter().filter_map(|stds| stds[axis].as_ref());
        let Some(std) = stated.next() else { continue };
        if let Some(twice) = stated.next() {
            return Err(document
                .refuse(twice.span(), "is stated by [[trial]], too")
                .expected("the standard error in one of the two tables"));
        }
        stds_m[axis] = document.number(std, LENGTH_STD_UM)?;
        if stds_m[axis] > MAX_RELATIVE_STD * length_m * (1.0 + 1e-9) {
            let length_um = LENGTH_UM.from_si(length_m);
            let reason = format!("is more than a third of the measured {name}, {} um", significant(length_um, 6));
            let most_um = (1e3 * MAX_RELATIVE_STD * length_um).floor() / 1e3;
            let refused = document.refuse(std.span(), reason);
            return Err(refused.expected(format!("a standard error of at most {most_um} um")));
        }
    }
    Ok(stds_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::pattern::{PatternFile, read_pattern};
    use crate::formats::spanned::Spanned;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Trial {
        depth_std_um: Option<Number>,
        pattern: Spanned<PatternFile>,
    }

    /// The standard errors by the keys of a trial and of its pattern.
    fn stds_um(trial: &str, pattern: &str) -> Result<[f64; 3], String> {
        let text = format!("{trial}\n[pattern]\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 12.0\n{pattern}\n");
        let document = Document::new("trials.toml", text);
        let read = || {
            let trial: Trial = document.parse()?;
            let own = [&None, &None, &trial.depth_std_um];
            let stds = [own, trial.pattern.get_ref().dimensions_std()];
            read(&document, &stds, &read_pattern(&document, &trial.pattern)?)
        };
        read()
            .map(|stds_m| stds_m.map(|std_m| LENGTH_UM.from_si(std_m)))
            .map_err(|refused: Diagnostic| refused.to_string())
    }

    #[test]
    fn a_third_of_the_dimension_is_the_most() {
        assert_eq!(stds_um("", ""), Ok([0.0; 3]));
        assert_eq!(stds_um("depth_std_um = 4.0", ""), Ok([0.0, 0.0, 4.0]));
        let refused = stds_um("depth_std_um = 11.0", "").unwrap_err();
        let says = "trials.toml:1: depth_std_um: 11.0 is more than a third of the measured depth, 12 um; expected a standard error of at \
                    most 4 um";
        assert!(refused.contains(says), "{refused}");
        assert!(stds_um("depth_std_um = -1.0", "").unwrap_err().contains("is out of range"));
    }

    #[test]
    fn a_trial_or_its_pattern_states_each_of_them() {
        assert_eq!(stds_um("depth_std_um = 1.0", "width_std_um = 8.0\nspacing_std_um = 13.0"), Ok([8.0, 13.0, 1.0]));
        assert_eq!(stds_um("", "depth_std_um = 1.3"), Ok([0.0, 0.0, 1.3]));
        let twice = stds_um("depth_std_um = 1.0", "depth_std_um = 1.0").unwrap_err();
        assert!(twice.starts_with("trials.toml:6: pattern.depth_std_um: 1.0 is stated by [[trial]], too"), "{twice}");
        let refused = stds_um("", "spacing_std_um = 124.0").unwrap_err();
        assert!(
            refused.contains("pattern.spacing_std_um: 124.0 is more than a third of the measured spacing"),
            "{refused}"
        );
    }
}
