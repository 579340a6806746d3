//! Tables of measured friction: CSV with a header line, in the dialects of spreadsheets of all countries.

use std::path::Path;

use slipgrid_infer::calibrate::{Measurement, StaticPeak};

use crate::formats::diagnostic::{Diagnostic, nearest};
use crate::formats::material::existing;
use crate::formats::measured::Placed;
use crate::formats::plausible::slip;
use crate::formats::source::read_letters;
use crate::formats::{Document, Spanned};
use slipgrid_base::units::{
    FORCE_N, FRICTION, FRICTION_STD, HUMIDITY_PCT, LENGTH_MM, Quantity, SPEED_MM_S, WEIGHT, tidy,
};
use slipgrid_traces::cells::{DecimalSigns, cut, expected_values, number_in, separator, unquoted};

/// Column `order`, the rank of a measurement in the order of all measurements: any positive number that rises with
/// time.
pub(crate) const ORDER: Quantity = WEIGHT;

/// Columns of a table: name, range of the numbers, and whether the column is required.
const COLUMNS: [(&str, Quantity, bool); 9] = [
    ("force_n", FORCE_N, true),
    ("speed_mm_s", SPEED_MM_S, true),
    ("humidity_pct", HUMIDITY_PCT, true),
    ("mu_dynamic", FRICTION, true),
    ("mu_dynamic_std", FRICTION_STD, true),
    ("mu_static", FRICTION, false),
    ("mu_static_std", FRICTION_STD, false),
    ("sliding_mm", LENGTH_MM, false),
    ("order", ORDER, false),
];
/// Maximum number of rows of a table. A laboratory measures some hundred conditions, and rows are compared in pairs.
const MAX_ROWS: usize = 5000;
/// Number of leading columns with the results of a measurement; the other columns describe how friction was measured.
const FRICTION_COLUMNS: usize = 7;

/// Reads the table that `key` of `document` names. A force in the table presses `samples` specimens at once; a returned
/// force presses one specimen.
///
/// # Errors
/// [`Diagnostic`] with line and column of the refused value.
pub fn read(document: &Document, key: &Spanned<String>, samples: u32) -> Result<Vec<Placed>, Diagnostic> {
    let path = existing(document, key, key.get_ref())?;
    let mut rows = parse(&path, &read_letters(document.source(), &path, "a table of measurements")?)?;
    rows.iter_mut().for_each(|row| row.measurement.force_n /= f64::from(samples));
    Ok(rows)
}

/// Reads a table from text; `path` names it in messages. Lines that start with `#` are comments. Tabs, semicolons or
/// commas separate cells; decimals may have commas unless commas separate cells.
///
/// # Errors
/// [`Diagnostic`] with line and column of the refused value.
pub fn parse(path: &Path, text: &str) -> Result<Vec<Placed>, Diagnostic> {
    let refuse = |line: u32, key: Option<&str>, value: Option<&str>, reason: String| Diagnostic {
        line: Some(line),
        key: key.map(Into::into),
        value: value.map(|value| format!("\"{value}\"").into()),
        ..Diagnostic::file(path, reason)
    };
    let mut lines = text
        .trim_start_matches('\u{feff}')
        .lines()
        .zip(1..)
        .map(|(line, number)| (number, line))
        // Spreadsheets write empty rows as separators, and quote cells that contain a separator.
        .filter(|(_, line)| {
            !line.trim_matches([' ', '\t', ';', ',', '"']).is_empty()
                && !line.trim_start_matches([' ', '"']).starts_with('#')
        });
    let names = || COLUMNS.map(|(name, _, _)| name);
    let Some((header_line, header)) = lines.next() else {
        return Err(Diagnostic::file(path, "has no header line").expected(names().join(",")));
    };
    let separator = separator(header).unwrap_or(',');
    let filled = |line| {
        let mut cells: Vec<&str> = cut(line, separator);
        cells.truncate(cells.iter().rposition(|cell| !unquoted(cell).is_empty()).map_or(0, |last| last + 1));
        cells
    };
    let width = cut(header, separator).len();
    let mut order = Vec::new();
    for name in filled(header).into_iter().map(unquoted) {
        let Some(column) = COLUMNS.iter().position(|column| column.0 == name) else {
            let mut refused = refuse(header_line, Some(name), None, "is not a known column".into())
                .expected(format!("one of {}", names().join(", ")));
            refused.suggestion = nearest(name, names()).map(Into::into);
            return Err(refused);
        };
        if order.contains(&column) {
            return Err(refuse(header_line, Some(name), None, "occurs twice".into()).expected("each column once"));
        }
        order.push(column);
    }
    let is_missing = |column: &usize| COLUMNS[*column].2 && !order.contains(column);
    if let Some((name, quantity, _)) = (0..COLUMNS.len()).find(is_missing).map(|column| COLUMNS[column]) {
        let not_measured = match name {
            "humidity_pct" => "; of a humidity that was not measured one number in all rows, as 50",
            _ => "",
        };
        return Err(refuse(header_line, Some(name), None, "is missing".into())
            .expected(format!("the columns {}; {name} is {quantity}{not_measured}", names()[..5].join(","))));
    }

    let (mut rows, mut signs) = (Vec::new(), DecimalSigns::default());
    for (line, content) in lines {
        // Concatenated tables repeat their header.
        if cut(content, separator).first().is_some_and(|cell| unquoted(cell) == COLUMNS[order[0]].0) {
            if filled(content).into_iter().map(unquoted).eq(filled(header).into_iter().map(unquoted)) {
                continue;
            }
            let columns: Vec<&str> = order.iter().map(|&column| COLUMNS[column].0).collect();
            return Err(refuse(line, None, None, format!("has a header again, another than line {header_line}"))
                .expected(format!("rows of numbers below {}", columns.join(","))));
        }
        let mut cells = cut(content, separator);
        // Allows as many empty cells behind the last column as the header has, because a decimal comma would shift the
        // other cells.
        if cells.len() == width && filled(content).len() <= order.len() {
            cells.truncate(order.len());
        }
        if cells.len() != order.len() {
            return Err(refuse(line, None, None, format!("has {} values", cells.len())).expected(expected_values(
                cells.len(),
                order.len(),
                separator,
            )));
        }
        let mut values = [None; COLUMNS.len()];
        for (&column, cell) in order.iter().zip(&cells) {
            let (name, quantity, required) = COLUMNS[column];
            let bare = unquoted(cell);
            if bare.is_empty() && !required {
                continue;
            }
            let number = bare.parse::<f64>().ok().or_else(|| number_in(cell, separator));
            let clash = number.and_then(|_| signs.take(cell, [line, column as u32]));
            if let Some((point, reason)) = clash {
                let name = COLUMNS.get(point.column).map(|column| column.0);
                return Err(refuse(point.line, name, Some(&point.number), reason).expected(DecimalSigns::EXPECTED));
            }
            let (reason, slip) = match number {
                Some(value) if quantity.accepts(value) => {
                    values[column] = Some(quantity.to_si(value));
                    continue;
                }
                Some(value) => ("is out of range", slip(quantity, value)),
                None => ("is no number", None),
            };
            let slip = slip.map_or_else(String::new, |slip| format!("; {slip}"));
            return Err(refuse(line, Some(name), Some(bare), reason.into()).expected(format!("{quantity}{slip}")));
        }
        let [required @ .., mu_static, mu_static_std, sliding_m, order] = values;
        // Empty cells of required columns have been refused.
        let [force_n, speed_m_s, humidity, mu_dynamic, mu_dynamic_std] = required.map(Option::unwrap_or_default);
        let (given, lacking) = (COLUMNS[5].0, COLUMNS[6].0);
        if mu_static.is_some() != mu_static_std.is_some() {
            let (there, absent) = if mu_static.is_some() { (given, lacking) } else { (lacking, given) };
            return Err(refuse(line, Some(there), None, format!("stands without {absent}"))
                .expected("both in a row, or neither where no static peak was measured"));
        }
        let static_peak = mu_static.zip(mu_static_std).map(|(mu, std)| StaticPeak { mu, std });
        let measurement = Measurement { force_n, speed_m_s, humidity, mu_dynamic, mu_dynamic_std, static_peak };
        if rows.len() == MAX_ROWS {
            let reason = format!("is row {}: too many for a table of means", MAX_ROWS + 1);
            return Err(refuse(line, None, None, reason).expected(format!(
                "at most {MAX_ROWS}, one a condition; samples in time are exports, which stand in [traces]"
            )));
        }
        rows.push(Placed { measurement, path: path.to_owned(), line, sliding_m, order });
    }
    if rows.is_empty() {
        return Err(Diagnostic::file(path, "has no rows").expected("at least one measurement"));
    }
    Ok(rows)
}

/// Formats `rows` as a table, with `comment` in a line above the header.
pub fn table(comment: &str, rows: &[Measurement]) -> String {
    let columns = COLUMNS.map(|(name, _, _)| name)[..FRICTION_COLUMNS].join(",");
    let mut text = format!("# {comment}\n{columns}\n");
    for row in rows {
        let rounded = |value: f64| tidy((value * 1e6).round() / 1e6).to_string();
        let optional = |value: Option<f64>| value.map_or_else(String::new, rounded);
        let cells = [
            row.force_n.to_string(),
            SPEED_MM_S.from_si(row.speed_m_s).to_string(),
            HUMIDITY_PCT.from_si(row.humidity).to_string(),
            rounded(row.mu_dynamic),
            rounded(row.mu_dynamic_std),
            optional(row.static_peak.map(|peak| peak.mu)),
            optional(row.static_peak.map(|peak| peak.std)),
        ];
        text += &format!("{}\n", cells.join(","));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measurements of a table.
    fn parse(path: &Path, text: &str) -> Result<Vec<Measurement>, Diagnostic> {
        Ok(super::parse(path, text)?.into_iter().map(|row| row.measurement).collect())
    }

    #[test]
    fn a_force_on_three_specimens_is_shared() {
        let table = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n200,2,15,0.25,0.002\n";
        let source = crate::formats::source::in_memory(&[("flat.csv", table.as_bytes())]);
        let document = Document::within(&source, "c.toml", "");
        let rows = read(&document, &Spanned::new(0..0, "flat.csv".to_owned()), 3).unwrap();
        assert!((rows[0].measurement.force_n - 200.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_table_with_too_many_rows_is_refused_at_the_first_of_them() {
        let header = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n";
        let of = |count: usize| parse(Path::new("a.csv"), &(header.to_owned() + &"50,2,15,0.25,0.002\n".repeat(count)));
        assert_eq!(of(MAX_ROWS).unwrap().len(), MAX_ROWS);
        let refused = of(300_000).unwrap_err().to_string();
        assert!(refused.starts_with("a.csv:5002: is row 5001: too many for a table of means"), "{refused}");
    }

    #[test]
    fn columns_may_stand_in_any_order_and_static_ones_be_empty() {
        let text = "# three repetitions\nmu_dynamic,force_n,speed_mm_s,humidity_pct,mu_dynamic_std,mu_static\n0.278, 200, 2, 15, 0.001,\n";
        let rows = parse(Path::new("a.csv"), text).unwrap();
        assert_eq!(
            rows,
            [Measurement {
                force_n: 200.0,
                speed_m_s: 2e-3,
                humidity: 0.15,
                mu_dynamic: 0.278,
                mu_dynamic_std: 0.001,
                static_peak: None,
            }]
        );
    }

    #[test]
    fn tables_of_spreadsheets_read_as_plain_ones() {
        let plain = "# three repeats\nforce_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std,mu_static,mu_static_std\n\
                     12.5,2,15,0.278,0.001,,\n25,0.4,15,0.3,0.002,0.32,0.01\n";
        let expected = parse(Path::new("a.csv"), plain).unwrap();
        assert_eq!((expected.len(), expected[0].force_n, expected[1].speed_m_s), (2, 12.5, 0.4e-3));
        let comma = |mark: &str| plain.replace(',', mark).replace('.', ",");
        // Commas separate cells and decimals; the decimals are quoted.
        let quoted =
            |cell: &str| if cell.contains('.') { format!("\"{}\"", cell.replace('.', ",")) } else { cell.to_owned() };
        let quoted_line = |line: &str| line.split(',').map(quoted).collect::<Vec<_>>().join(",") + "\n";
        let quoted: String = plain.lines().map(quoted_line).collect();
        for text in [
            plain.replace(',', ";"),
            comma(";"),
            comma("\t"),
            format!("\u{feff}{}", comma(";").replace('\n', "\r\n")),
            // Empty columns and rows of a sheet, and cells in quotes.
            comma(";").replace('\n', ";;\n") + ";;;;;;;;\n",
            plain.replace("12.5", "\"12.5\"").replace("force_n", "\"force_n\""),
            quoted,
        ] {
            assert_eq!(parse(Path::new("a.csv"), &text), Ok(expected.clone()), "{text}");
        }
        let refused = parse(Path::new("a.csv"), &plain.replace("0.278", "0,278")).unwrap_err().to_string();
        assert!(refused.contains("has 8 values") && refused.contains("semicolons"), "{refused}");
        let refused = parse(Path::new("a.csv"), &comma(";").replace("12,5", "1.012,5")).unwrap_err().to_string();
        assert!(refused.contains("force_n: \"1.012,5\" is no number"), "{refused}");
    }

    #[test]
    fn a_point_of_thousands_beside_decimal_commas_is_refused() {
        let header = "force_n;speed_mm_s;humidity_pct;mu_dynamic;mu_dynamic_std\n";
        let refused = |rows: &str| parse(Path::new("a.csv"), &format!("{header}{rows}")).unwrap_err().to_string();
        for (rows, line) in [
            ("500;2;15;0,248;0,002\n1.000;2;15;0,263;0,005\n", 3),
            ("1.000;2;15;0,263;0,005\n500;2;15;0,248;0,002\n", 2),
        ] {
            let said = refused(rows);
            let begins = format!("a.csv:{line}: force_n: \"1.000\" has a point, which may part decimals or thousands");
            assert!(said.starts_with(&begins) && said.contains("has a decimal comma"), "{said}");
            assert!(said.contains("expected one decimal sign"), "{said}");
        }
    }

    #[test]
    fn the_header_of_a_joined_table_is_left_out_and_another_one_refused() {
        let header = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std";
        let (one, two) = ("20,2,50,0.28,0.001", "50,2,50,0.27,0.001");
        let joined = format!("# first\n{header}\n{one}\n# second\n{header}\n{two}\n");
        assert_eq!(parse(Path::new("a.csv"), &joined), parse(Path::new("a.csv"), &format!("{header}\n{one}\n{two}\n")));
        let other =
            joined.replace(&format!("# second\n{header}"), &format!("# second\n{header},mu_static,mu_static_std"));
        let refused = parse(Path::new("a.csv"), &other).unwrap_err().to_string();
        assert!(refused.starts_with("a.csv:5: has a header again, another than line 2; expected rows"), "{refused}");
    }

    #[test]
    fn a_written_table_reads_back() {
        let row = Measurement {
            force_n: 66.5,
            speed_m_s: 0.4e-3,
            humidity: 0.15,
            mu_dynamic: 0.278123,
            mu_dynamic_std: 0.001,
            static_peak: Some(StaticPeak { mu: 0.3, std: 0.01 }),
        };
        let rows = [row, Measurement { static_peak: None, ..row }];
        assert_eq!(parse(Path::new("a.csv"), &table("by a test", &rows)).unwrap(), rows);
    }
}
