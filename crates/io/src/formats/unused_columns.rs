//! Finds unused columns of exports whose titles are similar to known ones.

use slipgrid_traces::columns::{Channel, Titles};
use slipgrid_traces::export::TraceFile;
use strsim::levenshtein;

/// Minimum number of letters of compared titles: shorter ones are similar to many words.
const FEWEST_LETTERS: usize = 4;

/// Warns of each unused column of `file` whose title is similar to a known title of a quantity that no column holds.
#[must_use]
pub(crate) fn near_titles(file: &TraceFile, titles: &Titles) -> Vec<String> {
    let is_free = |channel: &Channel| !file.used.contains(channel) && !titles.has_title(*channel);
    let free: Vec<Channel> = Channel::ALL.into_iter().filter(is_free).collect();
    let is_of_another = |title: &str| {
        let letters = Titles::letters_of(title);
        let names = |channel: Channel| channel.names().chain(channel.secondary_names());
        let is_one = |channel: Channel| names(channel).any(|name| letters.iter().any(|own| own == name));
        Channel::ALL.into_iter().any(|channel| !is_free(&channel) && is_one(channel))
    };
    let of_title = |title: &String| {
        if is_of_another(title) {
            return None;
        }
        let (channel, known, distance) = nearest_title(title, &free)?;
        let (what, key) = (channel.title(), channel.key());
        if distance == 0 {
            let units = channel.unit_words();
            return (!channel.is_needed())
                .then(|| format!("the column `{title}` is not used: its unit is none of those of a {what}, {units}"));
        }
        Some(format!(
            "the column `{title}` is not used: its title is not known, and near to `{known}` (did you mean that? `columns = {{ {key} = \
             \"{title}\" }}` in [traces] takes it as the {what})"
        ))
    };
    file.unused.iter().filter_map(of_title).collect()
}

/// Known title of one of the `channels` that is most similar to `title`, if similar enough, and the number of differing
/// letters.
fn nearest_title(title: &str, channels: &[Channel]) -> Option<(Channel, &'static str, usize)> {
    let own = Titles::letters_of(title);
    let long = |letters: &str| letters.chars().count() >= FEWEST_LETTERS;
    let known = channels.iter().flat_map(|channel| channel.names().map(|name| (*channel, name)));
    let pairs = known.filter(|(_, name)| long(name)).flat_map(|(channel, name)| {
        // A quarter of the letters may differ.
        own.iter().filter(|own| long(own)).map(move |own| {
            let distance = levenshtein(own, name);
            (distance <= own.chars().count().div_ceil(4)).then_some((channel, name, distance))
        })
    });
    pairs.flatten().min_by_key(|(.., distance)| *distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_traces::export::{ExportOptions, parse};

    fn said(header: &str, titles: &Titles) -> Vec<String> {
        let cells = header.split(',').count();
        let rows: String = (0..3).map(|i| vec![i.to_string(); cells].join(",") + "\n").collect();
        let options = ExportOptions { effective_radius_m: Some(0.04), titles: Some(titles), step: None };
        near_titles(&parse(&format!("{header}\n{rows}"), &options).unwrap(), titles)
    }

    #[test]
    fn titles_with_a_slip_of_the_pen_are_named_with_the_one_that_is_meant() {
        let none = Titles::default();
        for (title, known, key) in [
            ("Positon (mm)", "position", "position"),
            ("positon_mm", "position", "position"),
            ("Humidty [%]", "humidity", "humidity"),
            ("slidingsped", "slidingspeed", "speed"),
        ] {
            let said = said(&format!("time,Fx,Fz,{title}"), &none);
            assert_eq!(said.len(), 1, "{title}: {said:?}");
            assert!(
                said[0].starts_with(&format!("the column `{title}` is not used: its title is not known")),
                "{said:?}"
            );
            assert!(said[0].contains(&format!("near to `{known}`")), "{said:?}");
            assert!(said[0].contains(&format!("{key} = \"{title}\"")), "{said:?}");
        }
        let unit = said("time,Fx,Fz,Position (inch)", &none);
        assert!(unit.len() == 1 && unit[0].contains("its unit is none of those of a position, mm, m, cm"), "{unit:?}");
    }

    #[test]
    fn other_titles_and_those_of_quantities_that_are_there_are_not_named() {
        let none = Titles::default();
        for title in ["Temp", "Wear (um)", "Step", "Cycles", "Status", "Channel 4", "COF"] {
            assert_eq!(said(&format!("time,Fx,Fz,{title}"), &none), Vec::<String>::new(), "{title}");
        }
        assert_eq!(said("time,Fx,Fz,Position (mm),Positon (mm)", &none), Vec::<String>::new());
        let mut own = Titles::default();
        own.name(Channel::Position, "x_stage [mm]").unwrap();
        assert_eq!(said("time,Fx,Fz,Positon (mm)", &own), Vec::<String>::new());
        // A force that `columns` excludes is not a misspelt torque.
        own.name(Channel::Coefficient, "mu").unwrap();
        assert_eq!(said("time,mu,Friction force [N],Fz", &own), Vec::<String>::new());
    }
}
