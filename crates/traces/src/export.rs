//! Tribometer exports: tables with the instrument's own names, units, separators and decimal sign.

use crate::cells::{DecimalSigns, cut, number_in, separator, unquoted};
use crate::columns::{Channel, Column, Titles, UnknownUnit, columns, needed_columns};
use crate::missing_numbers::{Longest, Missing, Stretch};
use crate::{Tangential, TraceChannels};

/// One repeat as recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Its number in the file, from 1.
    pub number: usize,
    /// Time, friction and normal force.
    pub channels: TraceChannels,
    /// Mean amount of the recorded sliding speed, in m/s, where there is such a column.
    pub speed_m_s: Option<f64>,
    /// Mean recorded humidity, 0 to 1, where there is such a column.
    pub humidity: Option<f64>,
    /// Recorded position of every sample, in metres, no number where it was not recorded; empty where there is no such column with a unit.
    pub position_m: Vec<f64>,
    /// Rows without a number in a needed column, where there are any: left out.
    pub missing: Option<Missing>,
    /// Rows that repeat the row before them: left out.
    pub repeated_rows: usize,
}

/// A file of one repeat or several.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceFile {
    /// Its repeats.
    pub repeats: Vec<Recorded>,
    /// Names of columns that were not used.
    pub unused: Vec<String>,
    /// What the columns hold that were used.
    pub used: Vec<Channel>,
}

/// Marks at the beginning of a comment.
const COMMENTS: [&str; 4] = ["#", "%", "//", "\"#"];

/// Why an export was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{reason}; expected {expected}", .line.map_or_else(String::new, |line| format!("line {line}: ")))]
pub struct ExportError {
    /// Line in the file, from 1; `None` for the file as a whole.
    pub line: Option<u32>,
    /// Name of the column, as the file writes it.
    pub column: Option<String>,
    /// What stood there.
    pub value: Option<String>,
    /// Why it was refused.
    pub reason: String,
    /// What would be accepted.
    pub expected: String,
}

impl ExportError {
    fn at(line: Option<u32>, reason: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { line, column: None, value: None, reason: reason.into(), expected: expected.into() }
    }

    /// A column whose unit is not known.
    fn unit(line: u32, unknown: &UnknownUnit) -> Self {
        let [reason, expected] = unknown.words();
        Self { column: Some(unknown.name.clone()), ..Self::at(Some(line), reason, expected) }
    }
}

/// A line of the file, cut at its separators.
struct Line<'a> {
    number: u32,
    cells: Vec<&'a str>,
}

/// Reads an export from its text; `effective_radius_m` turns revolutions into speed, `titles` are its owner's.
///
/// A line that names time, friction and normal force is a header; what stands before the first is the
/// instrument's. A header met again begins the next repeat, as does a new number in a column `repeat`.
///
/// # Errors
/// [`ExportError`] with line and column of what was refused.
pub fn parse(text: &str, effective_radius_m: Option<f64>, titles: &Titles) -> Result<TraceFile, ExportError> {
    let text = text.trim_start_matches('\u{feff}');
    let lines = || {
        // A tab at the end of a line stands before an empty cell.
        text.lines().zip(1..).map(|(line, number)| (number, line)).filter(|(_, line)| {
            let start = line.trim_start();
            !start.is_empty() && !COMMENTS.iter().any(|mark| start.starts_with(mark))
        })
    };
    let Some((separator, header)) = lines().find_map(|(number, line)| {
        let separator = separator(line)?;
        let mut cells = cut(line, separator);
        // A separator behind the last title closes it, and opens no column.
        cells.truncate(cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1));
        // A table has at least two of its columns named; one may be what is missing, one may have an unknown unit.
        (needed_columns(&cells, titles) >= 2).then_some((separator, Line { number, cells }))
    }) else {
        return Err(no_header(lines(), titles));
    };
    let mut layout = columns(&header.cells, titles).map_err(|unknown| ExportError::unit(header.number, &unknown))?;
    let mut rows = lines().skip_while(|(number, _)| *number <= header.number).peekable();
    // A line of units below the names.
    if let Some((number, line)) = rows.peek().copied() {
        let cells = cut(line, separator);
        if !cells.iter().any(|cell| number_in(cell, separator).is_some()) {
            for (column, cell) in layout.iter_mut().zip(&cells) {
                if let Some(column) = column {
                    match column.set_unit(cell) {
                        Err(unknown) if column.channel != Channel::Position => {
                            return Err(ExportError::unit(number, &unknown));
                        }
                        _ => {}
                    }
                }
            }
            rows.next();
        }
    }
    check_layout(&layout, &header, effective_radius_m, titles)?;
    let is =
        |column: &Option<Column>, channel: Channel| column.as_ref().is_some_and(|column| column.channel == channel);
    if layout.iter().any(|column| is(column, Channel::Torque) || is(column, Channel::FrictionForce)) {
        // What the instrument computed from it is not needed.
        layout.iter_mut().filter(|column| is(column, Channel::Coefficient)).for_each(|column| *column = None);
    }
    // Of several positions, and of one without a unit, none is known to be that of sliding.
    if layout.iter().filter(|column| is(column, Channel::Position)).count() > 1 {
        layout.iter_mut().filter(|column| is(column, Channel::Position)).for_each(|column| *column = None);
    }
    let needed: Vec<&Column> = layout.iter().flatten().filter(|column| column.channel.is_needed()).collect();
    let mut repeats: Vec<Table> = vec![Table::default()];
    let (mut label, mut signs): (Option<f64>, _) = (None, DecimalSigns::default());
    for (number, line) in rows {
        let cells = cut(line, separator);
        if cells.starts_with(&header.cells) && cells[header.cells.len()..].iter().all(|cell| cell.is_empty()) {
            // The same header again: the next repeat.
            if repeats.last().is_some_and(|table| !table.is_empty()) {
                repeats.push(Table::default());
            }
            continue;
        }
        if cells.len() < header.cells.len() {
            let expected = format!("{}, as the header line", header.cells.len());
            return Err(ExportError::at(Some(number), format!("has {} values", cells.len()), expected));
        }
        check_signs(&layout, &cells, separator, number, &mut signs)?;
        let row = read_row(&layout, &cells, separator).map_err(|(name, cell)| ExportError {
            column: Some(name),
            value: Some(format!("\"{cell}\"")),
            ..ExportError::at(Some(number), "is no number", "a number, or nothing where it was not measured")
        })?;
        if let Some(next) = row.get(Channel::Repeat) {
            if label.is_some_and(|before| before != next) {
                repeats.push(Table::default());
            }
            label = Some(next);
        }
        if let Some(table) = repeats.last_mut() {
            let without = needed.iter().filter(|column| row.get(column.channel).is_none());
            table.push(number, &row, without.map(|column| column.name()));
        }
    }
    let radius_m = effective_radius_m.unwrap_or(f64::NAN);
    let (full, empty): (Vec<_>, Vec<_>) = (1..).zip(repeats).partition(|(_, table)| !table.is_empty());
    let repeats: Vec<Recorded> = full.into_iter().map(|(number, table)| table.recorded(number, radius_m)).collect();
    if repeats.is_empty() {
        return Err(no_sample(empty.into_iter().find_map(|(_, table)| table.missing.longest())));
    }
    let unused = header.cells.iter().zip(&layout).filter(|(cell, column)| column.is_none() && !cell.is_empty());
    let unused = unused.map(|(cell, _)| unquoted(cell).to_owned()).collect();
    Ok(TraceFile { repeats, unused, used: layout.iter().flatten().map(|column| column.channel).collect() })
}

/// The refusal of a table without a sample; `rows` are those in which a number is missing.
fn no_sample(rows: Option<Longest>) -> ExportError {
    let Some(Longest { rows, columns, lines: [first, _], .. }) = rows else {
        return ExportError::at(None, "has no rows", "samples below the header");
    };
    let reason = format!("none of the {rows} rows below the header has a number");
    let expected = "numbers of time, friction and normal force, in the same row";
    ExportError { column: Some(columns.join(", ")), ..ExportError::at(Some(first), reason, expected) }
}

/// Where titles of one's own are given, and where those that are known are listed.
const OWN_TITLES: &str = "in [traces]; see reference/trace-columns.md";

/// What is needed and not there, in words, and the titles that would be it.
fn lacks(lacking: &[&[Channel]], titles: &Titles) -> [String; 2] {
    let title =
        |channels: &[Channel]| channels.iter().map(|channel| channel.title()).collect::<Vec<_>>().join(" or the ");
    let missing: Vec<String> = lacking.iter().map(|channels| format!("the {}", title(channels))).collect();
    let known: Vec<String> = lacking
        .iter()
        .flat_map(|channels| channels.iter())
        .map(|channel| format!("for {}: {}", channel.title(), titles.of(*channel)))
        .collect();
    let keys: Vec<String> = lacking.iter().map(|channels| format!("{} = \"...\"", channels[0].key())).collect();
    [
        missing.join(", and none is "),
        format!("a title {}; or one's own as `columns = {{ {} }}` {OWN_TITLES}", known.join("; "), keys.join(", ")),
    ]
}

/// What stands for friction; the first is named in a proposal.
const FRICTION: [Channel; 3] = [Channel::FrictionForce, Channel::Torque, Channel::Coefficient];

/// The refusal of a file in which no line names the columns: the line above the numbers that looks most like one is shown.
fn no_header<'a>(lines: impl Iterator<Item = (u32, &'a str)>, titles: &Titles) -> ExportError {
    let cells = |line: &'a str| separator(line).map(|mark| (mark, cut(line, mark)));
    let is_numbers = |line: &'a str| {
        cells(line).is_some_and(|(mark, cells)| {
            let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
            filled.peek().is_some() && filled.all(|cell| number_in(cell, mark).is_some())
        })
    };
    // The most cells, then the most letters, and of equal ones the last.
    let looks = |line: &'a str| {
        let titled = cells(line).map_or(0, |(_, cells)| cells.iter().filter(|cell| !cell.is_empty()).count());
        (titled, line.chars().filter(|letter| letter.is_alphabetic()).count())
    };
    let best = lines.take_while(|(_, line)| !is_numbers(line)).max_by_key(|(_, line)| looks(line));
    let Some((number, line)) = best.filter(|(_, line)| looks(line).0 > 1) else {
        let expected = "a header with time, torque or friction force, and normal force, for instance `time_s,torque_nm,normal_force_n`";
        return ExportError::at(None, "has no line that names its columns", expected);
    };
    let found = cells(line).map_or_else(Vec::new, |(_, cells)| columns(&cells, titles).unwrap_or_default());
    let is_there = |channels: &[Channel]| found.iter().flatten().any(|column| channels.contains(&column.channel));
    let needed: [&[Channel]; 3] = [&[Channel::Time], &FRICTION, &[Channel::NormalForce]];
    let lacking: Vec<&[Channel]> = needed.into_iter().filter(|channels| !is_there(channels)).collect();
    let [missing, expected] = lacks(&lacking, titles);
    let shown: String = line
        .trim()
        .chars()
        .filter(|c| !c.is_control() || *c == '\t')
        .map(|c| if c == '\t' { ' ' } else { c })
        .take(80)
        .collect();
    ExportError::at(
        Some(number),
        format!("`{shown}` looks most like the titles of columns, but none is {missing}"),
        expected,
    )
}

fn check_layout(
    layout: &[Option<Column>],
    header: &Line<'_>,
    effective_radius_m: Option<f64>,
    titles: &Titles,
) -> Result<(), ExportError> {
    let refuse = |reason: &str, expected: &str| Err(ExportError::at(Some(header.number), reason, expected));
    let unknown: Vec<String> = header
        .cells
        .iter()
        .zip(layout)
        .filter(|(cell, column)| column.is_none() && !cell.is_empty())
        .map(|(cell, _)| {
            format!("`{}`", unquoted(cell).chars().filter(|c| !c.is_control()).take(40).collect::<String>())
        })
        .collect();
    let absent = |channels: &[Channel]| {
        let [missing, expected] = lacks(&[channels], titles);
        let unknown = &unknown[..unknown.len().min(4)];
        let among = if unknown.is_empty() { String::new() } else { format!("; not known are {}", unknown.join(", ")) };
        refuse(&format!("no column is {missing}{among}"), &expected)
    };
    let count = |channel: Channel| layout.iter().flatten().filter(|column| column.channel == channel).count();
    let [torques, forces] = [count(Channel::Torque), count(Channel::FrictionForce)];
    for channel in [Channel::Time, Channel::NormalForce] {
        let what = channel.title();
        match count(channel) {
            1 => {}
            // A coefficient has been divided by it.
            0 if channel == Channel::NormalForce && torques + forces == 0 && count(Channel::Coefficient) > 0 => {}
            0 => return absent(&[channel]),
            found => return refuse(&format!("{found} columns are the {what}"), "one"),
        }
    }
    match (torques + forces, count(Channel::Coefficient)) {
        (0, 1) => Ok(()),
        (0, 0) => absent(&FRICTION),
        (0, found) => refuse(&format!("{found} columns are the friction coefficient"), "one"),
        (1, _) if effective_radius_m.is_none() && torques == 1 => refuse(
            "holds a torque, and no effective radius is given",
            "`effective_radius_mm` in [traces] or --effective-radius-mm: the distance from the axis to a specimen's centre",
        ),
        (1, _) => Ok(()),
        _ => refuse("has both a torque and a friction force, or two of one", "one of them; rename or remove the other"),
    }
}

/// A cell that says that nothing was measured.
fn is_missing(cell: &str) -> bool {
    matches!(unquoted(cell).to_ascii_lowercase().as_str(), "" | "nan" | "-" | "--" | "---" | "n/a" | "na")
}

/// Values of one row by channel, SI units.
#[derive(Clone, Default, PartialEq)]
struct Row([Option<f64>; Channel::COUNT]);

impl Row {
    fn get(&self, channel: Channel) -> Option<f64> {
        self.0[channel as usize]
    }
}

fn read_row(layout: &[Option<Column>], cells: &[&str], separator: char) -> Result<Row, (String, String)> {
    let mut row = Row::default();
    for (column, cell) in layout.iter().zip(cells) {
        let Some(column) = column else { continue };
        match number_in(cell, separator) {
            Some(value) => row.0[column.channel as usize] = Some(column.to_si(value)).filter(|value| !value.is_nan()),
            None if is_missing(cell) || column.channel == Channel::Position => {}
            None => return Err((column.name().to_owned(), unquoted(cell).to_owned())),
        }
    }
    Ok(row)
}

/// Refuses numbers with decimal commas and numbers with points in one table; `line` is that of the `cells`.
fn check_signs(
    layout: &[Option<Column>],
    cells: &[&str],
    separator: char,
    line: u32,
    signs: &mut DecimalSigns,
) -> Result<(), ExportError> {
    for ((column, cell), at) in layout.iter().zip(cells).zip(0..) {
        if column.is_none() || number_in(cell, separator).is_none() {
            continue;
        }
        if let Some((point, reason)) = signs.take(cell, [line, at]) {
            let column = layout.get(point.column).and_then(Option::as_ref);
            return Err(ExportError {
                column: column.map(|column| column.name().to_owned()),
                value: Some(format!("\"{}\"", point.number)),
                ..ExportError::at(Some(point.line), reason, DecimalSigns::EXPECTED)
            });
        }
    }
    Ok(())
}

/// Samples of one repeat.
#[derive(Default)]
struct Table {
    time_s: Vec<f64>,
    torque_nm: Vec<f64>,
    friction_n: Vec<f64>,
    coefficient: Vec<f64>,
    normal_force_n: Vec<f64>,
    speed_m_s: Vec<f64>,
    turns_per_s: Vec<f64>,
    humidity: Vec<f64>,
    position_m: Vec<f64>,
    /// Time of its first row, on the file's own clock; one that lacks other numbers counts too.
    start_s: Option<f64>,
    missing: Stretch,
    repeated: usize,
    last: Option<Row>,
}

impl Table {
    fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Takes the row in line `number`, unless it is `without` a number in columns that are needed.
    fn push<'a>(&mut self, number: u32, row: &Row, without: impl Iterator<Item = &'a str>) {
        let mut without = without.peekable();
        self.start_s = self.start_s.or(row.get(Channel::Time));
        let time_s = match row.get(Channel::Time) {
            Some(time_s) if without.peek().is_none() => time_s,
            time_s => return self.missing.add(number, time_s, without),
        };
        self.missing.end();
        if self.last.as_ref() == Some(row) {
            self.repeated += 1;
            return;
        }
        self.last = Some(row.clone());
        self.time_s.push(time_s);
        self.normal_force_n.extend(row.get(Channel::NormalForce));
        self.torque_nm.extend(row.get(Channel::Torque));
        self.friction_n.extend(row.get(Channel::FrictionForce));
        self.coefficient.extend(row.get(Channel::Coefficient));
        self.speed_m_s.extend(row.get(Channel::Speed).map(f64::abs));
        self.turns_per_s.extend(row.get(Channel::Revolutions).map(f64::abs));
        self.position_m.push(row.get(Channel::Position).unwrap_or(f64::NAN));
        self.humidity.extend(row.get(Channel::Humidity));
    }

    fn recorded(self, number: usize, radius_m: f64) -> Recorded {
        let mean = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            mean.is_finite().then_some(mean)
        };
        let start_s = self.start_s.unwrap_or(0.0);
        // v = 2 pi n r_eff
        let turning = mean(&self.turns_per_s).map(|turns| std::f64::consts::TAU * turns * radius_m);
        Recorded {
            number,
            speed_m_s: mean(&self.speed_m_s).or(turning).filter(|speed| speed.is_finite()),
            humidity: mean(&self.humidity),
            position_m: if self.position_m.iter().any(|x| x.is_finite()) { self.position_m } else { Vec::new() },
            missing: self.missing.found(start_s, self.time_s.len() + self.repeated),
            repeated_rows: self.repeated,
            channels: TraceChannels {
                tangential: if !self.torque_nm.is_empty() {
                    Tangential::TorqueNm(self.torque_nm)
                } else if !self.friction_n.is_empty() {
                    Tangential::ForceN(self.friction_n)
                } else {
                    Tangential::Coefficient(self.coefficient)
                },
                time_s: self.time_s,
                start_s,
                normal_force_n: self.normal_force_n,
            },
        }
    }
}

#[cfg(test)]
#[path = "export_tests.rs"]
mod tests;
