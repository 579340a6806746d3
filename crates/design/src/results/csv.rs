//! Cells of CSV tables that spreadsheet programs open.

/// Returns `text` as the content of a cell. Text that a spreadsheet would read as a formula gets a leading apostrophe
/// (OWASP, "CSV injection"). Full-width signs count too, because some spreadsheets read them as ordinary signs.
pub fn guard_formula(text: &str) -> String {
    const FORMULA: [char; 10] = ['=', '+', '-', '@', '\t', '\r', '＝', '＋', '－', '＠'];
    if text.trim_start_matches(['\n', ' ']).starts_with(FORMULA) { format!("'{text}") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_is_a_formula() {
        for text in ["=1+1", "+1", "-2+3", "@SUM(1)", "\t=1", "\r=1", " =1", "\n=1", "＝1"] {
            assert_eq!(guard_formula(text), format!("'{text}"));
        }
        for text in ["", "a=b", "1-2", "'=1", "[-1]"] {
            assert_eq!(guard_formula(text), text);
        }
    }
}
