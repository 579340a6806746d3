//! Standard errors of the measured dimensions of trials.

use super::document::Document;
use super::values::Number;
use crate::diagnostic::Diagnostic;
use slipgrid_units::{LENGTH_STD_UM, LENGTH_UM, tidy};

/// Largest standard error of a dimension of a trial over the dimension: beyond, it is known that there is a cavity and hardly more.
const MAX_RELATIVE_STD: f64 = 1.0 / 3.0;

/// The standard error of the dimension `name` of a trial, which measures `length_m`, in metres; 0 where the file does not say it.
///
/// # Errors
/// [`Diagnostic`] for a number out of range, and for more than a third of the dimension.
pub fn read(document: &Document, written: Option<&Number>, name: &str, length_m: f64) -> Result<f64, Diagnostic> {
    let Some(written) = written else { return Ok(0.0) };
    let std_m = document.number(written, LENGTH_STD_UM)?;
    if std_m <= MAX_RELATIVE_STD * length_m * (1.0 + 1e-9) {
        return Ok(std_m);
    }
    let length_um = LENGTH_UM.from_si(length_m);
    let reason = format!("is more than a third of the measured {name}, {} um", tidy(length_um));
    let most_um = (1e3 * MAX_RELATIVE_STD * length_um).floor() / 1e3;
    Err(document.refuse(written.span(), reason).expected(format!("a standard error of at most {most_um} um")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Trial {
        depth_std_um: Option<Number>,
    }

    fn depth_std_m(keys: &str) -> Result<f64, String> {
        let document = Document::new("trials.toml", keys);
        let trial: Trial = document.parse().map_err(|refused| refused.to_string())?;
        read(&document, trial.depth_std_um.as_ref(), "depth", LENGTH_UM.to_si(12.0))
            .map_err(|refused| refused.to_string())
    }

    #[test]
    fn a_third_of_the_dimension_is_the_most() {
        assert_eq!(depth_std_m(""), Ok(0.0));
        assert_eq!(depth_std_m("depth_std_um = 4.0"), Ok(LENGTH_UM.to_si(4.0)));
        let refused = depth_std_m("\ndepth_std_um = 11.0").unwrap_err();
        let says = "trials.toml:2: depth_std_um: 11.0 is more than a third of the measured depth, 12 um; expected a standard error of at \
                    most 4 um";
        assert!(refused.contains(says), "{refused}");
        assert!(depth_std_m("depth_std_um = -1.0").unwrap_err().contains("is out of range"));
    }
}
