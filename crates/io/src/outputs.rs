//! Files of one result, in memory.

use std::io::{self, Write};
use std::sync::Arc;

use serde::Serialize;
use slipgrid_design::results::{NoJsonForm, json_and_timings};

/// Content of an output file: writes its bytes, identical ones with every call. Files too large for memory are generated
/// during writing.
pub type Content = Arc<dyn Fn(&mut dyn Write) -> io::Result<()> + Send + Sync>;

/// Files of one result: names and contents.
#[derive(Clone, Default)]
pub struct Outputs {
    files: Vec<(String, Content)>,
}

impl std::fmt::Debug for Outputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

impl Outputs {
    /// Adds the file `name` with the content `bytes`.
    pub fn add(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        let bytes = bytes.into();
        self.add_stream(name, move |to| to.write_all(&bytes));
    }

    /// Adds `record` as result.json without the wall times, and the wall times as timings.json.
    ///
    /// # Errors
    /// [`NoJsonForm`] if a value has no JSON form.
    pub fn add_record(&mut self, record: &impl Serialize) -> Result<(), NoJsonForm> {
        let [result, timings] = json_and_timings(record)?;
        self.add("result.json", result);
        self.add("timings.json", timings);
        Ok(())
    }

    /// Adds all files of `others` with `prefix` before each name; the prefix `next-1/` puts the files into a folder.
    pub fn add_below(&mut self, prefix: &str, others: &Self) {
        self.files.extend(others.files.iter().map(|(name, content)| (format!("{prefix}{name}"), Arc::clone(content))));
    }

    /// Adds a file that `write` generates piece by piece during writing.
    pub fn add_stream(
        &mut self,
        name: impl Into<String>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + Send + Sync + 'static,
    ) {
        self.files.push((name.into(), Arc::new(write)));
    }

    /// The file `name` as text; `None` if it does not exist or is not text.
    pub fn text(&self, name: &str) -> Option<String> {
        let (_, content) = self.files.iter().find(|(other, _)| other == name)?;
        let mut bytes = Vec::new();
        content(&mut bytes).ok()?;
        String::from_utf8(bytes).ok()
    }

    /// Names of the files, in order of addition.
    pub fn names(&self) -> Vec<&str> {
        self.files.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Names and contents of the files, in order of addition.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Content)> {
        self.files.iter().map(|(name, content)| (name.as_str(), content))
    }
}
