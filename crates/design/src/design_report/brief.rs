//! Screen output after a job: advice, texture, expected values and limiting inputs, in about 20 lines of 100 characters.

use std::fmt::Write as _;

use super::DesignReport;
use crate::prediction::{ModelledRatio, SampleReport, percent};
use crate::results::{SCREEN_WIDTH, doubts_in_brief, wrapped};

/// Maximum number of loads that the screen lists; the others are counted.
const MAX_LOADS: usize = 8;
/// Maximum number of limits and bounds for which the screen shows the chance without the limit or bound.
const MAX_LIFTED: usize = 2;

impl DesignReport {
    /// Formats the report for the screen; [`DesignReport::summary`] has all details.
    pub fn brief(&self) -> String {
        let mut text = wrapped(&format!("{}: {}", self.name, self.words), SCREEN_WIDTH, "  ", 3) + "\n\n";
        let texture = format!("  {}; {:.1} % of the face", self.design_in_words(), 100.0 * self.specimen_areal_density);
        let _ = writeln!(text, "{}", wrapped(&texture, SCREEN_WIDTH, "  ", 2));
        let of_model = |modelled: &ModelledRatio| vec![format!("{:.3} +- {:.3}", modelled.ratio, modelled.std)];
        let table = self.table_of_loads(&[], of_model).brief(MAX_LOADS);
        let _ = write!(text, "\n  {}\n{table}", self.quantity_in_words());
        self.below_the_table().iter().for_each(|line| {
            let _ = writeln!(text, "{}", wrapped(&format!("  {line}"), SCREEN_WIDTH, "    ", 2));
        });
        text.push('\n');
        text += &doubts_in_brief(&self.doubts());
        let _ = writeln!(text, "- {}", self.lacking());
        text
    }

    /// Lines below the table: expected value of the goal, number of trials, main limit of the chance, other textures
    /// worth cutting, and bounds or limits that keep the target out of reach.
    fn below_the_table(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.goal_in_words().into_iter().chain([self.trials_in_words()]).collect();
        lines.extend(self.limit_in_words());
        if !self.others.is_empty() {
            let other = |of: &SampleReport| {
                let chance = of.chance.map_or_else(String::new, |chance| format!(" ({})", percent(chance)));
                of.design.lengths_in_words().replace(' ', "") + &chance
            };
            let others: Vec<String> = self.others.iter().map(other).collect();
            lines.push(format!("also worth cutting (width/spacing/depth): {}", others.join(", ")));
        }
        lines.extend(self.bounds_in_words());
        lines.extend(self.blocked_in_words().into_iter().take(MAX_LIFTED));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prediction::Expected;
    use crate::results::LoadReport;
    use slipgrid_laser::export::{Removal, Tolerances};
    use slipgrid_model::material::Provenance;

    #[test]
    fn the_gravest_doubt_comes_first() {
        let mut report = DesignReport {
            sample: SampleReport { violations: vec!["a land is too small".into()], ..SampleReport::default() },
            laser_warnings: vec!["bursts are coarse".into()],
            material: Provenance { warnings: vec!["the map is spiky".into()], ..Provenance::default() },
            confirmed: vec![LoadReport {
                pressure_mpa: 2.6,
                friction_extrapolated: true,
                status: "converged".into(),
                ..LoadReport::default()
            }],
            measured_mpa: Some([0.6, 2.5]),
            ..DesignReport::default()
        };
        let places = |report: &DesignReport| {
            let doubts = report.doubts();
            ["too small", "spiky", "outside the measured", "coarse"]
                .map(|words| doubts.iter().position(|doubt| doubt.contains(words)).unwrap())
        };
        assert_eq!(places(&report), [0, 1, 2, 3]);
        // Passes that make another depth make every number void.
        let removal = Removal {
            passes: 1,
            depth_um: 7.2,
            speed_for_depth_mm_s: Some(144.0),
            warnings: vec!["1 pass makes 7.2 um in the middle of a cavity, +44 % of the design's 5 um: 144 mm/s instead of 100 makes it right".into()],
            ..Removal::default()
        };
        report.sample.design.depth_um = 5.0;
        report.laser.speed_mm_s = Some(100.0);
        report.removal = Some(removal.clone());
        assert_eq!(report.doubts()[1], removal.warnings[0]);
        assert_eq!((places(&report), report.doubts().len()), ([0, 2, 3, 4], 5));
        assert!(report.brief().contains("\n! 1 pass makes 7.2 um"), "{}", report.brief());
        let fine = Removal { depth_um: 5.2, warnings: Vec::new(), ..removal };
        report.removal = Some(fine);
        assert_eq!(report.wrong_depth(), None);
        report.tolerances = Some(Tolerances { depth_um: Some(0.1), ..Tolerances::default() });
        assert!(report.wrong_depth().unwrap().contains("5.2 um in the middle of a cavity, +4 %"));
        report.removal = None;
        // Far outside, friction is a guess.
        report.measured_mpa = Some([0.6, 1.3]);
        assert_eq!(places(&report), [0, 2, 1, 3]);
    }

    /// Tests with twelve loads, six doubts of a paragraph each, and three other textures.
    #[test]
    fn a_long_report_fits_on_the_screen() {
        let expected = |load: u32| Expected { pressure_mpa: f64::from(load), median: 0.85, ..Expected::default() };
        let sample = SampleReport {
            chance: Some(0.5),
            expected: (1..=12).map(expected).collect(),
            modelled: vec![ModelledRatio::default(); 12],
            ..SampleReport::default()
        };
        let doubt =
            |number: u32| format!("doubt {number} {}; and {}", "of many words".repeat(9), "its reason ".repeat(40));
        let report = DesignReport {
            name: "a name".into(),
            words: "cut a trial: 50 % chance that a cut sample is on target".into(),
            others: vec![sample.clone(); 3],
            material: Provenance { warnings: (1..=6).map(doubt).collect(), ..Provenance::default() },
            sample,
            ..DesignReport::default()
        };
        let text = report.brief();
        assert!(text.lines().count() <= 26 && text.lines().all(|line| line.chars().count() <= 100), "{text}");
        for said in ["50 % chance", "4 more rows", "3 more doubts", "doubt 3", "also worth cutting", "not modelled"] {
            assert!(text.contains(said), "{said}: {text}");
        }
        assert!(!text.contains("its reason") && report.summary().contains("its reason"), "{text}");
    }
}
