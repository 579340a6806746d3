//! The columns of a table: which of them are used, and why a header is refused.

use crate::cells::{cut, number_in, separator, unquoted};
use crate::columns::{Channel, Column, Priority, Titles, columns, may_be_force, needed_columns};
use crate::export::ExportError;

/// Where titles of one's own are given, and where those that are known are listed.
const OWN_TITLES: &str = "in [traces]; see reference/trace-columns.md";
/// Difference of two columns over the largest amount up to which they hold the same: friction is not known better.
const SAME_NUMBERS: f64 = 1e-3;

/// A numbered line of the file.
pub(crate) type Line<'a> = (u32, &'a str);

/// The columns of a table.
pub(crate) struct Layout<'a> {
    pub(crate) separator: char,
    /// Titles, without empty cells at the end.
    pub(crate) titles: Vec<&'a str>,
    /// What the columns hold; `None` for those that are not used.
    pub(crate) columns: Vec<Option<Column>>,
    /// The column of time.
    pub(crate) time: usize,
    /// The line below the titles holds units.
    pub(crate) has_units: bool,
}

/// The separator and the titles of `line`, if it is a header: at least two needed columns are named, as one may be missing.
pub(crate) fn header<'a>(line: &'a str, titles: &Titles) -> Option<(char, Vec<&'a str>)> {
    let separator = separator(line)?;
    let mut cells = cut(line, separator);
    // A separator behind the last title closes it, and opens no column.
    cells.truncate(cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1));
    (needed_columns(&cells, titles) >= 2).then_some((separator, cells))
}

/// A cell that says that nothing was measured.
pub(crate) fn is_missing(cell: &str) -> bool {
    matches!(unquoted(cell).to_ascii_lowercase().as_str(), "" | "nan" | "-" | "--" | "---" | "n/a" | "na")
}

impl<'a> Layout<'a> {
    /// The columns of a table with these titles in line `number`, and the lines `below` it.
    ///
    /// # Errors
    /// [`ExportError`] for units that are not known, columns that are missing, and several columns of one channel that differ.
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
            layout.take_units(units)?;
        }
        layout.keep_own_friction(number)?;
        let rows = &below[usize::from(layout.has_units).min(below.len())..];
        for channel in Channel::ALL {
            layout.keep_one(channel, number, rows, own)?;
        }
        layout.check(number, own, has_radius)?;
        layout.time = layout.find(Channel::Time).unwrap_or(0);
        Ok(layout)
    }

    /// Whether a row cannot be used without a number in `column`.
    pub(crate) fn requires(&self, column: &Column) -> bool {
        column.channel.is_needed() && (column.channel != Channel::Coefficient || !self.has_force())
    }

    /// Whether words may stand in `column`: no trace needs its numbers.
    pub(crate) fn may_hold_words(&self, column: &Column) -> bool {
        let is_checked_only = column.channel == Channel::Coefficient && !self.requires(column);
        is_checked_only || matches!(column.channel, Channel::Position | Channel::Step)
    }

    /// Titles of columns that are not used.
    pub(crate) fn unused(&self) -> Vec<String> {
        let cells = self.titles.iter().zip(&self.columns);
        let unused = cells.filter(|(cell, column)| column.is_none() && !cell.is_empty());
        unused.map(|(cell, _)| unquoted(cell).chars().filter(|c| !c.is_control()).collect()).collect()
    }

    /// The first column of `channel`.
    pub(crate) fn find(&self, channel: Channel) -> Option<usize> {
        self.columns.iter().position(|column| column.as_ref().is_some_and(|column| column.channel == channel))
    }

    /// Whether friction is a torque or a force, so that a coefficient is what the instrument computed from it.
    fn has_force(&self) -> bool {
        self.find(Channel::Torque).or_else(|| self.find(Channel::FrictionForce)).is_some()
    }

    fn all(&self, channel: Channel) -> Vec<usize> {
        let is = |column: &Option<Column>| column.as_ref().is_some_and(|column| column.channel == channel);
        (0..self.columns.len()).filter(|&at| is(&self.columns[at])).collect()
    }

    fn drop_where(&mut self, is_dropped: impl Fn(&Column) -> bool) {
        self.columns
            .iter_mut()
            .filter(|column| column.as_ref().is_some_and(&is_dropped))
            .for_each(|column| *column = None);
    }

    /// Takes the units of a line below the titles, if it is one.
    fn take_units(&mut self, (number, line): &Line<'a>) -> Result<(), ExportError> {
        let cells = cut(line, self.separator);
        // The unit of a coefficient may be 1.
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

    /// Keeps that channel of friction whose title `columns` gives; a coefficient stays to be compared with it.
    fn keep_own_friction(&mut self, number: u32) -> Result<(), ExportError> {
        let own: Vec<&Column> =
            self.columns.iter().flatten().filter(|column| column.priority == Priority::Own).collect();
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

    /// Of several columns of `channel`, keeps the one that counts.
    fn keep_one(&mut self, channel: Channel, number: u32, rows: &[Line<'a>], own: &Titles) -> Result<(), ExportError> {
        let first = self.columns.iter().flatten().filter(|column| column.channel == channel).map(|c| c.priority).min();
        let Some(first) = first else { return Ok(()) };
        self.drop_where(|column| column.channel == channel && column.priority != first);
        let several = self.all(channel);
        if several.len() < 2 {
            return Ok(());
        }
        let kept = match same_columns(self, &several, rows, own) {
            Ok(kept) => Some(kept),
            // Of numbers of a step the first counts; of several other channels that are not needed none is known to be the right one.
            Err(_) if matches!(channel, Channel::Step | Channel::Repeat) => Some(several[0]),
            Err(_) if !channel.is_needed() || (channel == Channel::Coefficient && self.has_force()) => None,
            Err(differ) => return Err(self.clash(channel, number, &several, differ)),
        };
        several.into_iter().filter(|at| Some(*at) != kept).for_each(|at| self.columns[at] = None);
        Ok(())
    }

    /// The refusal of several columns of one channel that differ first in line `differ`.
    fn clash(&self, channel: Channel, number: u32, several: &[usize], differ: u32) -> ExportError {
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
            let [missing, expected] = lacks(&[channels], own);
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
        // Without a column of the load, the stated force acts as a dead weight, unless some column may be the load.
        let is_unknown = |title: &str| columns(&[title], &Titles::default()).is_ok_and(|found| found == [None]);
        let may_be_load = !own.has_own(Channel::NormalForce)
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

/// The column of `several` that holds what all of them hold in `rows`: of amounts beside signed numbers the signed ones.
///
/// # Errors
/// The first line in which two of them differ.
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
            (Some(a), Some(b)) => (a.abs() - b.abs()).abs() > SAME_NUMBERS * largest,
            _ => false,
        };
        if let Some((line, _)) = numbers.iter().find(|(_, values)| differs(values)) {
            return Err(*line);
        }
    }
    let has_signs = |&&index: &&usize| column(index).any(|value| value < 0.0);
    Ok(several[*filled.iter().find(has_signs).unwrap_or(&first)])
}

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

/// The refusal of a file in which no line names the columns: the line above the numbers that looks most like one is shown.
pub(crate) fn no_header<'a>(lines: impl Iterator<Item = Line<'a>>, titles: &Titles) -> ExportError {
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
    let needed: [&[Channel]; 3] = [&[Channel::Time], &Channel::FRICTION, &[Channel::NormalForce]];
    let lacking: Vec<&[Channel]> = needed.into_iter().filter(|channels| !is_there(channels)).collect();
    let [missing, expected] = lacks(&lacking, titles);
    // Tabs cannot be told from spaces in a message.
    let titled: Vec<&str> = line.trim().split('\t').map(str::trim).filter(|title| !title.is_empty()).collect();
    let shown: String = titled.join("; ").chars().filter(|c| !c.is_control()).collect();
    ExportError::at(
        Some(number),
        format!("`{shown}` looks most like the titles of columns, but none is {missing}"),
        expected,
    )
}
