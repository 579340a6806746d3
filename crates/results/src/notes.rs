//! What a model states, as notes of a text: what bears on a decision first, and last, in one note, how it was computed.

/// How statements begin that only say how something was computed. One that is not among them stands by itself.
const COMPUTED: [&str; 23] = [
    "dynamic: ",
    "reference: ",
    "cell: ",
    "sample: ",
    "in time: ",
    "two dimensions: ",
    "three dimensions, ",
    "area law: f = 1 up to ",
    "unilateral contact: ",
    "mean local coefficients: ",
    "mean of ",
    "one draw of the local coefficients: ",
    "warm start: ",
    "grooves: as many columns ",
    "strips longer than ",
    "dimensions that are no whole blocks: ",
    "nearest whole blocks ",
    "blocks of ",
    "searched in space: ",
    "dynamic_mean: fitted ",
    "dynamic_std_error: ",
    "factor_std: ",
    "the map is taken as one period ",
];

/// `statements` as lines that begin with `- `, in their order but for those on the computation, which are the last line.
#[must_use]
pub fn notes<'a>(statements: impl IntoIterator<Item = &'a str>) -> String {
    let is_computed = |statement: &&str| COMPUTED.iter().any(|beginning| statement.starts_with(beginning));
    let (computed, own): (Vec<&str>, Vec<&str>) = statements.into_iter().partition(is_computed);
    let mut text: String = own.iter().map(|statement| format!("- {statement}\n")).collect();
    if !computed.is_empty() {
        text += &format!("- how it was computed: {}\n", computed.join("; "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_bears_on_a_decision_stands_first_and_nothing_is_lost() {
        let said =
            notes(["cell: one period", "no area law: Amontons-Coulomb friction", "two dimensions: plane stress", "b"]);
        let expected = "- no area law: Amontons-Coulomb friction\n- b\n\
                        - how it was computed: cell: one period; two dimensions: plane stress\n";
        assert_eq!(said, expected);
        assert_eq!(notes(["b"]), "- b\n");
        assert_eq!(notes([]), "");
    }
}
