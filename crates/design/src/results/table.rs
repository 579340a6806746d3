//! Tables as text.

use std::fmt;

use slipgrid_base::units::counted;

use crate::results::notes::WHERE_ALL;

/// Text table with right-aligned columns.
#[derive(Clone, Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates a table with the column names `header` and no rows.
    pub fn new<'a>(header: impl IntoIterator<Item = &'a str>) -> Self {
        Self { rows: vec![header.into_iter().map(str::to_owned).collect()] }
    }

    /// Starts a table with one row per record; [`Records::column`] adds its columns.
    pub fn of<T>(records: &[T]) -> Records<'_, T> {
        Records { records, table: Self { rows: vec![Vec::new(); records.len() + 1] } }
    }

    /// Names of the columns.
    pub fn header(&self) -> &[String] {
        self.rows.first().map_or(&[], Vec::as_slice)
    }

    /// Cells below the header, row by row.
    pub fn body(&self) -> &[Vec<String>] {
        self.rows.get(1..).unwrap_or_default()
    }

    /// Formats the table as CSV, without quotes.
    pub fn csv(&self) -> String {
        self.rows.iter().map(|row| row.join(",") + "\n").collect()
    }

    /// Appends a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Formats the first `most` rows for the screen, and counts the others.
    pub fn brief(&self, most: usize) -> String {
        let more = (self.rows.len() - 1).saturating_sub(most);
        let first = Self { rows: self.rows[..self.rows.len() - more].to_vec() };
        if more == 0 { first.to_string() } else { format!("{first}  {}: {}\n", counted(more, "more row"), WHERE_ALL) }
    }
}

/// Table with one row per record, built column by column.
#[derive(Clone, Debug)]
pub struct Records<'a, T> {
    records: &'a [T],
    table: Table,
}

impl<T> Records<'_, T> {
    /// Adds the column `name`; `cell` formats the cell of a record.
    pub fn column(&mut self, name: impl Into<String>, cell: impl Fn(&T) -> String) {
        let cells = std::iter::once(name.into()).chain(self.records.iter().map(cell));
        self.table.rows.iter_mut().zip(cells).for_each(|(row, cell)| row.push(cell));
    }

    /// Adds the column `name` of numbers, each with the fewest digits that read back as the same number; an unknown
    /// number gives an empty cell.
    pub fn numbers<N: Into<Option<f64>>>(&mut self, name: impl Into<String>, number: impl Fn(&T) -> N) {
        self.column(name, |record| number(record).into().map_or_else(String::new, |number| number.to_string()));
    }

    /// The table with the columns added so far.
    pub fn table(self) -> Table {
        self.table
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for (cell, width) in row.iter().zip(&widths) {
                line += &format!("  {cell:>width$}");
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Formats a number with `digits` decimals, or a dash if it is absent or not finite. A number that rounds to zero has
/// no sign.
pub fn fixed(value: Option<f64>, digits: usize) -> String {
    let Some(value) = value.filter(|value| value.is_finite()) else { return "-".to_owned() };
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|digit| matches!(digit, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

/// Formats a number, followed by `+-` and its error if both are known, or a dash.
pub fn with_error(value: impl Into<Option<f64>>, std: impl Into<Option<f64>>, digits: usize) -> String {
    let value = value.into().filter(|value| value.is_finite());
    let std = std.into().filter(|std| value.is_some() && std.is_finite());
    let error = std.map_or_else(String::new, |std| format!(" +- {}", fixed(Some(std.abs()), digits)));
    fixed(value, digits) + &error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        for (value, text) in
            [(-0.0, "0.0000"), (-4e-5, "0.0000"), (-6e-5, "-0.0001"), (4e-5, "0.0000"), (-10.0, "-10.0000")]
        {
            assert_eq!(fixed(Some(value), 4), text);
        }
        assert_eq!((fixed(Some(-0.4), 0), fixed(Some(f64::NAN), 2)), ("0".to_owned(), "-".to_owned()));
    }

    #[test]
    fn a_long_table_is_cut_and_says_so() {
        let mut table = Table::new(["P MPa"]);
        (0..5).for_each(|row| table.row([row.to_string()]));
        assert_eq!(table.brief(5), table.to_string());
        assert_eq!(table.brief(3), "  P MPa\n      0\n      1\n      2\n  2 more rows: with --details\n");
    }

    #[test]
    fn records_have_the_columns_of_their_table() {
        let mut records = Table::of(&[0.65, 12.5]);
        records.column("P MPa", f64::to_string);
        records.column("mu", |pressure| with_error(0.1 * pressure, (*pressure < 1.0).then_some(0.01), 2));
        let table = records.table();
        assert_eq!(table.to_string(), "  P MPa            mu\n   0.65  0.07 +- 0.01\n   12.5          1.25\n");
        assert_eq!((table.header(), table.body().len()), (&["P MPa".to_owned(), "mu".to_owned()][..], 2));
        assert_eq!(with_error(None, 0.1, 2), "-");
    }
}
