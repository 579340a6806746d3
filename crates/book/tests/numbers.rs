//! Checks that the numbers that the book quotes are in their sources.

use crate::{book, program, root, text};

/// The table of measured and modelled ratios equals the output of `slipgrid validate`.
#[test]
fn the_ratios_of_the_validation_are_what_the_program_prints() {
    let output = program().current_dir(root()).arg("validate").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    let numbers = |line: &str| {
        let words = line.split_whitespace().filter(|word| *word != "+-");
        words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()
    };
    let rows: Vec<Vec<f64>> = printed.lines().filter_map(numbers).collect();
    // Tables of grooves and of squares: force, pressure, measured, Amontons-Coulomb, three slopes and the measured depth, with
    // the errors of all but Amontons-Coulomb.
    let of = |force_n: f64| rows.iter().filter(move |row| row.len() == 13 && row[0] == force_n);
    let chapter = text(&book().join("evidence/validation.md"));
    let mut compared = 0;
    for line in chapter.lines().filter(|line| line.contains(" N | ")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let force_n: f64 = cells[0].strip_suffix(" N").unwrap().parse().unwrap();
        let both: Vec<&Vec<f64>> = of(force_n).collect();
        assert_eq!(both.len(), 2, "{force_n} N: {printed}");
        let measured = &both[0][2..4];
        // The chapter has the grooves first.
        let modelled = both.iter().flat_map(|row| row[5..11].chunks(2));
        for (cell, now) in
            std::iter::once(cells[1]).chain(cells[3..].iter().copied()).zip([measured].into_iter().chain(modelled))
        {
            let kept: Vec<f64> = cell.split('±').map(|number| number.trim().parse().unwrap()).collect();
            let is_kept = kept.iter().zip(now).all(|(kept, now)| (kept - now).abs() < 1.5e-3);
            assert!(is_kept, "{force_n} N: {kept:?}, now {now:?}");
            compared += 1;
        }
    }
    assert_eq!(compared, 4 * 7);
}

/// The table rows that the evidence quotes are in the page that the program wrote.
#[test]
fn the_laboratories_of_the_book_are_those_of_the_kept_page() {
    let page = text(&root().join("tests/accuracy/laboratories.md"));
    let chapter = text(&book().join("theory/trials.md"));
    let mut rows = 0;
    for line in chapter.lines().filter(|line| {
        line.starts_with("| nothing") || line.starts_with("| one groove") || line.starts_with("| the published")
    }) {
        for number in line.split('|').filter_map(|cell| cell.trim().parse::<f64>().ok()) {
            assert!(page.contains(&format!("{number:.2}")), "{number} of {line}");
            rows += 1;
        }
    }
    assert_eq!(rows, 15);
}
