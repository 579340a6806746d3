//! Selection of the columns of a table that are used, and refusal of headers.

use crate::cells::{cut, number_in, separator, unquoted};
use crate::columns::{Channel, Column, Priority, Titles, columns, may_be_force, needed_columns};
use crate::export_error::ExportError;

/// Hint for messages: where custom titles are given, and where known titles are listed.
const TITLES_HINT: &str = "in [traces]; see reference/trace-columns.md";
/// Two columns hold the same quantity if their absolute values differ in no row by more than this fraction of the
/// largest absolute value in the first column. Friction is not known more precisely.
const COLUMN_TOLERANCE: f64 = 1e-3;

/// A line of the file with its number, from 1.
pub(crate) type Line<'a> = (u32, &'a str);

pub(crate) struct Layout<'a> {
    pub(crate) separator: char,
    /// Titles, without empty cells at the end.
    pub(crate) titles: Vec<&'a str>,
    /// Quantity of each column; `None` for columns that are not used.
    pub(crate) columns: Vec<Option<Column>>,
    /// Index of the time column.
    pub(crate) time: usize,
    /// Whether the line below the titles holds units.
    pub(crate) has_units: bool,
}

/// Returns the separator and the titles in `line` if at least two needed columns (time, friction, normal force) are
/// named, and `None` for other lines. A header may lack the third column here; a later check names the missing column
/// in its message.
pub(crate) fn header<'a>(line: &'a str, titles: &Titles) -> Option<(char, Vec<&'a str>)> {
    let separator = separator(line)?;
    let mut cells = cut(line, separator);
    // A separator after the last title does not begin a column.
    cells.truncate(cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1));
    (needed_columns(&cells, titles) >= 2).then_some((separator, cells))
}

/// Whether a cell stands for a missing value: empty, `nan`, `-`, `n/a` or similar.
pub(crate) fn is_missing(cell: &str) -> bool {
    matches!(unquoted(cell).to_ascii_lowercase().as_str(), "" | "nan" | "-" | "--" | "---" | "n/a" | "na")
}

impl<'a> Layout<'a> {
    /// Selects the columns of a table with `titles` in line `number`. `below` are the lines after line `number`, `own`
    /// the custom titles; without `has_radius`, a torque is refused.
    ///
    /// # Errors
    /// [`ExportError`] for unknown units, missing columns, and several columns of a channel that differ.
    pub(crate) fn new(
        number: u32,
        (separator, titles): (char, Vec<&'a str>),
        below: &[Line<'a>],
        own: &Titles,
        has_radius: bool,
    ) -> Result<Self, ExportError> {
        let columns = columns(&titles, own).map_err(|unknown| ExportError::unit(number, &unknown))?;
        let mut layout = Self { separator, titles, columns, time: 0, has_units: false };
        if let Some(units) = below.first() {
            layout.read_units(units)?;
        }
        layout.select_friction(number)?;
        let rows = &below[usize::from(layout.has_units).min(below.len())..];
        for channel in Channel::ALL {
            layout.select_column(channel, number, rows, own)?;
        }
        layout.check(number, own, has_radius)?;
        layout.time = layout.find(Channel::Time).unwrap_or(0);
        Ok(layout)
    }

    /// Whether a row must be skipped if it has no number in `column`.
    pub(crate) fn requires(&self, column: &Column) -> bool {
        column.channel.is_needed() && (column.channel != Channel::Coefficient || !self.has_force())
    }

    /// Whether `column` may hold words, because no trace needs its numbers.
    pub(crate) fn may_hold_words(&self, column: &Column) -> bool {
        let is_checked_only = column.channel == Channel::Coefficient && !self.requires(column);
        is_checked_only || matches!(column.channel, Channel::Position | Channel::Step)
    }

    /// The first needed column in which a row holds words, and its cell; `None` if there is none.
    pub(crate) fn words_for_numbers<'c>(&self, cells: &[&'c str]) -> Option<(&Column, &'c str)> {
        let is_word = |cell: &str| number_in(cell, self.separator).is_none() && !is_missing(cell);
        let used = self.columns.iter().zip(cells).filter_map(|(column, cell)| Some((column.as_ref()?, *cell)));
        used.into_iter().find(|(column, cell)| self.requires(column) && is_word(cell))
    }

    /// Titles of columns that are not used.
    pub(crate) fn unused(&self) -> Vec<String> {
        let cells = self.titles.iter().zip(&self.columns);
        let unused = cells.filter(|(cell, column)| column.is_none() && !cell.is_empty());
        unused.map(|(cell, _)| unquoted(cell).chars().filter(|c| !c.is_control()).collect()).collect()
    }

    /// Index of the first column of `channel`; `None` if no column is used for it.
    pub(crate) fn find(&self, channel: Channel) -> Option<usize> {
        self.all(channel).next()
    }

    /// Whether a torque or a friction force was recorded, so that the instrument computed a coefficient from it.
    fn has_force(&self) -> bool {
        self.find(Channel::Torque).or_else(|| self.find(Channel::FrictionForce)).is_some()
    }

    fn all(&self, channel: Channel) -> impl Iterator<Item = usize> {
        let columns = self.columns.iter().enumerate();
        columns.filter(move |(_, column)| column.as_ref().is_some_and(|c| c.channel == channel)).map(|(at, _)| at)
    }

    fn drop_where(&mut self, is_dropped: impl Fn(&Column) -> bool) {
        self.columns
            .iter_mut()
            .filter(|column| column.as_ref().is_some_and(&is_dropped))
            .for_each(|column| *column = None);
    }

    /// Sets the units from the line below the titles, if this line holds units.
    fn read_units(&mut self, (number, line): &Line<'a>) -> Result<(), ExportError> {
        let cells = cut(line, self.separator);
        // The unit of a coefficient may be `1`.
        let is_word = |cell: &&str| number_in(cell, self.separator).is_none() || unquoted(cell) == "1";
        let has_letters = |cell: &&str| !is_missing(cell) && cell.contains(|c: char| c.is_alphabetic() || c == '%');
        self.has_units = cells.len() > 1 && cells.iter().all(is_word) && cells.iter().any(has_letters);
        if !self.has_units {
            return Ok(());
        }
        for (column, cell) in self.columns.iter_mut().zip(&cells) {
            match column.as_mut().map_or(Ok(()), |column| column.set_unit(cell)) {
                Err(unknown) if unknown.channel.is_needed() => return Err(ExportError::unit(*number, &unknown)),
                Err(_) => *column = None,
                Ok(()) => {}
            }
        }
        Ok(())
    }

    /// Keeps only the friction channel that has a custom title, if any; a column of coefficients is kept as a check.
    /// Refuses custom titles for both friction force and torque.
    fn select_friction(&mut self, number: u32) -> Result<(), ExportError> {
        let own: Vec<&Column> =
            self.columns.iter().flatten().filter(|column| column.priority == Priority::Custom).collect();
        let is_own = |channel: Channel| own.iter().any(|column| column.channel == channel);
        let [force, torque, coefficient] = Channel::FRICTION.map(is_own);
        if force && torque {
            return Err(ExportError::at(
                Some(number),
                "has a torque and a friction force, and `columns` names both",
                "one of the two keys in `columns`",
            ));
        }
        if force || torque || coefficient {
            self.drop_where(|column| match column.channel {
                Channel::FrictionForce => !force,
                Channel::Torque => !torque,
                _ => false,
            });
        }
        Ok(())
    }

    /// Keeps one column of `channel`, of those with the highest priority. If their values differ, keeps the first for
    /// step and repeat numbers, and none for another optional channel (also for a coefficient beside a force or
    /// torque); otherwise returns an error. `rows` are the lines below the header, which is line `number`.
    fn select_column(
        &mut self,
        channel: Channel,
        number: u32,
        rows: &[Line<'a>],
        own: &Titles,
    ) -> Result<(), ExportError> {
        let first = self.columns.iter().flatten().filter(|column| column.channel == channel).map(|c| c.priority).min();
        let Some(first) = first else { return Ok(()) };
        self.drop_where(|column| column.channel == channel && column.priority != first);
        let several: Vec<usize> = self.all(channel).collect();
        if several.len() < 2 {
            return Ok(());
        }
        let kept = match same_columns(self, &several, rows, own) {
            Ok(kept) => Some(kept),
            // The first of several columns with step or repeat numbers is used. Other optional channels are left out,
            // because the right column is not known.
            Err(_) if matches!(channel, Channel::Step | Channel::Repeat) => Some(several[0]),
            Err(_) if !channel.is_needed() || (channel == Channel::Coefficient && self.has_force()) => None,
            Err(differ) => return Err(self.ambiguous_columns(channel, number, &several, differ)),
        };
        several.into_iter().filter(|at| Some(*at) != kept).for_each(|at| self.columns[at] = None);
        Ok(())
    }

    /// Creates the error for several columns of `channel` that differ first in line `differ`.
    fn ambiguous_columns(&self, channel: Channel, number: u32, several: &[usize], differ: u32) -> ExportError {
        let names: Vec<&str> = several.iter().map(|&at| unquoted(self.titles[at])).collect();
        let listed: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let mark = if names.iter().all(|name| *name == names[0]) { " #1" } else { "" };
        ExportError::at(
            Some(number),
            format!(
                "the columns {} are each the {}, and differ first in line {differ}",
                listed.join(", "),
                channel.title()
            ),
            format!("the one to use, as `columns = {{ {} = \"{}{mark}\" }}` in [traces]", channel.key(), names[0]),
        )
    }

    fn check(&self, number: u32, own: &Titles, has_radius: bool) -> Result<(), ExportError> {
        let name = |channel: Channel| self.find(channel).map(|at| unquoted(self.titles[at]));
        let absent = |channels: &[Channel]| {
            let [missing, expected] = describe_missing(&[channels], own);
            let unknown: Vec<String> = self.unused().iter().map(|title| format!("`{title}`")).collect();
            let among =
                if unknown.is_empty() { String::new() } else { format!("; not known are {}", unknown.join(", ")) };
            Err(ExportError::at(Some(number), format!("no column is {missing}{among}"), expected))
        };
        if name(Channel::Time).is_none() {
            return absent(&[Channel::Time]);
        }
        if let [Some(force), Some(torque), _] = Channel::FRICTION.map(name) {
            let keys =
                format!("`columns = {{ torque = \"{torque}\" }}` or `columns = {{ friction_force = \"{force}\" }}`");
            return Err(ExportError::at(
                Some(number),
                format!("`{torque}` is a torque and `{force}` a friction force"),
                format!("the one to use, as {keys} in [traces]"),
            ));
        }
        if Channel::FRICTION.into_iter().all(|channel| name(channel).is_none()) {
            return absent(&Channel::FRICTION);
        }
        // Without a load column the stated force acts as a dead weight, unless an unknown column may be the load.
        let is_unknown = |title: &str| columns(&[title], &Titles::default()).is_ok_and(|found| found == [None]);
        let may_be_load = !own.has_title(Channel::NormalForce)
            && self.unused().iter().any(|title| may_be_force(title) && is_unknown(title));
        let is_hidden = own.expects(Channel::NormalForce) || may_be_load;
        if name(Channel::NormalForce).is_none() && self.has_force() && is_hidden {
            return absent(&[Channel::NormalForce]);
        }
        if name(Channel::Torque).is_some() && !has_radius {
            return Err(ExportError::at(
                Some(number),
                "holds a torque, and no effective radius is given",
                "`effective_radius_mm` in [traces] or --effective-radius-mm: the distance from the axis to a specimen's centre",
            ));
        }
        Ok(())
    }
}

/// Selects one of the columns `several`, given by index, if all hold equal absolute values in `rows`; a column with
/// signs is preferred to one with absolute values.
///
/// # Errors
/// The first line in which two of the columns differ.
fn same_columns(layout: &Layout<'_>, several: &[usize], rows: &[Line<'_>], own: &Titles) -> Result<usize, u32> {
    let mut numbers: Vec<(u32, Vec<Option<f64>>)> = Vec::new();
    for (number, line) in rows {
        let cells = cut(line, layout.separator);
        let value = |&at: &usize| {
            let value = cells.get(at).and_then(|cell| number_in(cell, layout.separator))?;
            layout.columns[at].as_ref().map(|column| column.to_si(value))
        };
        let values: Vec<Option<f64>> = several.iter().map(value).collect();
        if values.iter().any(Option::is_some) {
            numbers.push((*number, values));
        } else if header(line, own).is_some() {
            break;
        }
    }
    let column = |index: usize| numbers.iter().filter_map(move |(_, values)| values[index]);
    let filled: Vec<usize> = (0..several.len()).filter(|&index| column(index).next().is_some()).collect();
    let Some((&first, others)) = filled.split_first() else { return Ok(several[0]) };
    let largest = column(first).fold(0.0_f64, |most, value| most.max(value.abs()));
    for &other in others {
        let differs = |values: &[Option<f64>]| match (values[first], values[other]) {
            (Some(a), Some(b)) => (a.abs() - b.abs()).abs() > COLUMN_TOLERANCE * largest,
            _ => false,
        };
        if let Some((line, _)) = numbers.iter().find(|(_, values)| differs(values)) {
            return Err(*line);
        }
    }
    let has_signs = |&&index: &&usize| column(index).any(|value| value < 0.0);
    Ok(several[*filled.iter().find(has_signs).unwrap_or(&first)])
}

/// Describes the missing channels, and the titles that would be recognized. Each entry of `lacking` lists channels of
/// which one is needed.
fn describe_missing(lacking: &[&[Channel]], titles: &Titles) -> [String; 2] {
    let title =
        |channels: &[Channel]| channels.iter().map(|channel| channel.title()).collect::<Vec<_>>().join(" or the ");
    let missing: Vec<String> = lacking.iter().map(|channels| format!("the {}", title(channels))).collect();
    let known: Vec<String> = lacking
        .iter()
        .flat_map(|channels| channels.iter())
        .map(|channel| format!("for {}: {}", channel.title(), titles.list(*channel)))
        .collect();
    let keys: Vec<String> = lacking.iter().map(|channels| format!("{} = \"...\"", channels[0].key())).collect();
    [
        missing.join(", and none is "),
        format!("a title {}; or one's own as `columns = {{ {} }}` {TITLES_HINT}", known.join("; "), keys.join(", ")),
    ]
}

/// Creates the error for a file without a header; it shows the line that looks most like a header.
pub(crate) fn no_header<'a>(lines: impl Iterator<Item = Line<'a>>, titles: &Titles) -> ExportError {
    let cells = |line: &'a str| separator(line).map(|mark| (mark, cut(line, mark)));
    let is_numbers = |line: &'a str| {
        cells(line).is_some_and(|(mark, cells)| {
            let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
            filled.peek().is_some() && filled.all(|cell| number_in(cell, mark).is_some())
        })
    };
    // Most cells, then most letters; on a tie the last line.
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
    let needed: [&[Channel]; 3] = [&[Channel::Time], &Channel::FRICTION, &[Channel::NormalForce]];
    let lacking: Vec<&[Channel]> = needed.into_iter().filter(|channels| !is_there(channels)).collect();
    let [missing, expected] = describe_missing(&lacking, titles);
    // A reader cannot see tabs in a message.
    let titled: Vec<&str> = line.trim().split('\t').map(str::trim).filter(|title| !title.is_empty()).collect();
    let shown: String = titled.join("; ").chars().filter(|c| !c.is_control()).collect();
    ExportError::at(
        Some(number),
        format!("`{shown}` looks most like the titles of columns, but none is {missing}"),
        expected,
    )
}
