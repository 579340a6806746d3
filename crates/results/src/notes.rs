//! What a model says of itself, as notes of a text: what bears on a decision first, and last, in one note, how it was computed.

/// `model` as lines that begin with `- `, in their order, and `method` as the last one.
#[must_use]
pub fn notes<'a>(model: impl IntoIterator<Item = &'a str>, method: &[String]) -> String {
    let mut text: String = model.into_iter().map(|statement| format!("- {statement}\n")).collect();
    if !method.is_empty() {
        text += &format!("- how it was computed: {}\n", method.join("; "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn how_it_was_computed_is_the_last_note() {
        let method = ["cell: one period".to_owned(), "two dimensions: plane stress".to_owned()];
        let said = notes(["no area law: Amontons-Coulomb friction", "b"], &method);
        let expected = "- no area law: Amontons-Coulomb friction\n- b\n\
                        - how it was computed: cell: one period; two dimensions: plane stress\n";
        assert_eq!(said, expected);
        assert_eq!(notes(["b"], &[]), "- b\n");
        assert_eq!(notes([], &[]), "");
    }
}
