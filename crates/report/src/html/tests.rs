use slipgrid_design::DesignReport;
use slipgrid_design::records::{RimSensitivityReport, RimSlopeReport};
use slipgrid_material::{AreaLaw, LocalFriction};
use slipgrid_pattern::{Rim, RimProfile};
use slipgrid_results::RimReport;
use slipgrid_springblock::Load;

use super::fixture::{goal, number, report};
use super::*;
use crate::Outputs;

/// The page of `report`, with coefficients and an area law of two pressures.
fn page_of(report: &DesignReport, outputs: &Outputs) -> String {
    let friction = LocalFriction::new(0.31, 0.28, 0.05).unwrap();
    let loads = [0.65e6, 2.6e6].map(|pressure_pa| Load { pressure_pa, friction });
    let law = AreaLaw::new(vec![0.7e6, 2e6], vec![1.0, 0.1]).unwrap().with_factor_std(vec![0.0, 0.02]).unwrap();
    design(report, Some(&law), &loads, outputs, None)
}

#[test]
fn grooves_that_cross_are_given_by_both_directions() {
    let said = |angle_deg, crossing_angle_deg| {
        let mut report = report();
        (report.design.angle_deg, report.design.crossing_angle_deg) = (angle_deg, crossing_angle_deg);
        page_of(&report, &Outputs::default())
    };
    let turned = "<th scope=\"row\">grooves turned by</th><td>";
    for (first, crossing, words) in [
        (Some(15.0), Some(60.0), Some("15 degrees, crossed by grooves turned by 75 degrees")),
        (None, Some(90.0), Some("0 degrees, crossed by grooves turned by 90 degrees")),
        (Some(30.0), None, Some("30 degrees")),
        (None, None, None),
    ] {
        let page = said(first, crossing);
        let found = page.split_once(turned).map(|(_, rest)| rest.split_once('<').unwrap().0);
        assert_eq!(found, words, "{first:?} {crossing:?}");
        assert!(page.matches(turned).count() <= 1);
    }
}

/// Tags that are opened and not closed, or the other way round.
fn unbalanced(page: &str) -> Vec<String> {
    const VOID: [&str; 2] = ["meta", "!DOCTYPE"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        let end = at + rest[at..].find('>').unwrap();
        let tag = &rest[at + 1..end];
        let name: String =
            tag.trim_start_matches('/').chars().take_while(|c| !c.is_whitespace() && *c != '/').collect();
        if let Some(name) = tag.strip_prefix('/') {
            match open.pop() {
                Some(last) if last == name => {}
                other => return vec![format!("{other:?} closed by {name}")],
            }
        } else if !tag.ends_with('/') && !VOID.contains(&name.as_str()) {
            open.push(name.clone());
        }
        rest = &rest[end + 1..];
        if name == "script" && !tag.starts_with('/') {
            rest = &rest[rest.find("</script>").unwrap()..];
        }
    }
    open
}

#[test]
fn a_page_holds_every_number_with_its_error_and_asks_the_network_for_nothing() {
    let mut outputs = Outputs::default();
    for name in ["target.svg", "pattern.svg", "interface-2.6mpa.svg", "friction-2.6mpa.svg"] {
        let picture = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\" viewBox=\"0 0 9 9\">\
            <clipPath id=\"frame\"/><g clip-path=\"url(#frame)\"/></svg>";
        outputs.add(name, picture);
    }
    outputs.add("process.toml", "name = \"x < y\"\n");
    outputs.add("scene.toml", "[material]\nname = \"m & n\"\n");
    let page = page_of(&report(), &outputs);
    assert_eq!(unbalanced(&page), Vec::<String>::new());
    for said in [
        "<h1>a &lt;b&gt; &amp; &quot;c&quot;</h1>",
        "<p class=\"date\">2026-11-22</p>",
        "<div class=\"narrow\"><div class=\"card\"",
        "<p class=\"chance\">16 % chance that a cut sample is on target (limited by Young's modulus).</p>",
        "<div style=\"width:16.0%\">",
        "It does not include the following, for which no error is given: how far the model itself is off.",
        "The design was chosen of 3.",
        "Target met by the model.",
        "<td>0.97 ± 0.01</td>",
        "Status at every pressure: converged.",
        "0.9616 ± 0.0012",
        "0.8355 ± 0.0008",
        "one standard deviation of time",
        "<td>0.0007</td>",
        "0.829 ± 0.041",
        "<td>0.750 to 0.910</td>",
        "-3.50 ± 0.02",
        "with the material as calibrated: 62.0 ± 1.5 %, by",
        "<td>0.0100</td>",
        "<td>0.1000 ± 0.0200</td>",
        "<td>0.3100</td>",
        "standard deviation of 5.0 %",
        "one search",
        "0.9400 to 0.9800",
        "synthetic surface",
        "The material is doubtful: spikes: 5 points stand alone.",
        "At 2.6 MPa cavities close",
        "name = &quot;x &lt; y&quot;",
        "name = &quot;m &amp; n&quot;",
        "prefers-color-scheme:dark",
        "@media print",
        "Improvements during the search",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // Columns without a value take no room.
    assert!(page.contains(">mu flat</button>") && !page.contains(">mu static</button>"));
    assert!(!page.contains(">status</button>"));
    let mut differing = report();
    differing.errors.by_pressure[0].mu_static = Some(number(0.27, Some(0.003)));
    differing.confirmed[1].status = "no_onset".into();
    differing.goal = Some(goal());
    let differing = page_of(&differing, &outputs);
    assert!(differing.contains(">mu static</button>") && differing.contains("<td>no_onset</td>"));
    assert!(!differing.contains("Status at every"));
    assert!(
        differing.contains("Goal: the least difference of ratios. Predicted 0.10000, confirmed 0.11000 ± 0.00200;")
    );
    // Names of different pictures do not meet, and nothing is fetched.
    assert!(page.contains("id=\"p1-frame\"") && page.contains("url(#p4-frame)") && !page.contains("\"frame\""));
    let bare = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!bare.contains("http") && !bare.contains("src=") && !bare.contains("@import"));
    assert_eq!(page, page_of(&report(), &outputs));
}

#[test]
fn the_page_says_what_the_text_says_of_the_verdict_and_of_shares() {
    let outputs = Outputs::default();
    let mut found = report();
    let robustness = found.robustness.as_mut().unwrap();
    (robustness.samples.probability, robustness.samples.probability_stderr) = (Some(0.0), Some(0.0));
    // The search for a goal was cut short, and its design confirmed.
    (found.status, found.goal, found.misfit.confirmed) = ("budget".into(), Some(goal()), Some(0.9));
    let (page, text) = (page_of(&found, &outputs), found.summary());
    assert!(page.contains("with the material as calibrated: none, by") && text.contains("none of "), "{text}");
    let verdict = found.verdict();
    assert!(verdict.is_met && verdict.words.starts_with("best so far"), "{verdict:?}");
    assert!(text.contains(&verdict.words) && page.contains(&verdict.words[1..]), "{text}");
    assert!(!page.contains("not confirmed") && !page.contains("verdict missed"));
}

#[test]
fn a_load_beyond_those_measured_stands_where_the_chance_is() {
    let mut found = report();
    assert!(!found.summary().contains("outside the measured range"));
    found.confirmed[1].friction_extrapolated = true;
    found.measured_mpa = Some([0.7, 1.4]);
    let text = found.summary();
    let said = "\n! at 2.6 MPa outside the measured range: the nearest measurement's coefficients were taken (friction was measured from \
                0.7 to 1.4 MPa)\n";
    let (place, table) = (text.find(said).unwrap_or_else(|| panic!("{text}")), text.find("peak MPa").unwrap());
    assert!(place < table && text.matches("outside the measured range").count() == 1, "{text}");
    // What is doubtful of the material stands on the screen as on the page.
    assert!(text.contains("\n! the material is doubtful: spikes: 5 points stand alone\n"), "{text}");
    // The peaks beside what was confirmed are those of the steady cell, and said to be.
    assert!(text.contains("peak is the steady cell's largest pressure, over a block\n"), "{text}");
}

#[test]
fn what_is_estimated_beyond_the_blocks_stands_beside_the_value_that_it_is_of() {
    let mut report = report();
    for (loads, change) in [(&mut report.predicted, 0.0281), (&mut report.confirmed, 0.0068)] {
        loads.iter_mut().for_each(|load| load.ratio_discretization_error = Some(change));
    }
    let page = page_of(&report, &Outputs::default());
    let row = page.split(">change of confirmed for vanishing blocks<").nth(1).unwrap().split("<tbody>").nth(1).unwrap();
    let row = row.split("</tr>").next().unwrap();
    let cells: Vec<&str> = row.split("</td>").map(|cell| cell.rsplit('>').next().unwrap()).collect();
    assert_eq!((cells[3], cells[5]), ("0.0281", "0.0068"), "{row}");
}

#[test]
fn a_goal_alone_has_no_tolerance_and_no_distance() {
    let mut report = report();
    report.goal = Some(goal());
    report.target = slipgrid_design::records::TargetReport {
        value: None,
        tolerance: None,
        lowest: vec![None; report.target.pressure_mpa.len()],
        highest: vec![None; report.target.pressure_mpa.len()],
        ..report.target
    };
    let robustness = report.robustness.as_mut().unwrap();
    for found in [Some(&mut robustness.samples), robustness.with_material.as_mut()].into_iter().flatten() {
        (found.probability, found.probability_stderr) = (None, None);
    }
    assert!(!robustness.text().contains("tolerances alone"), "{}", robustness.text());
    let page = page_of(&report, &Outputs::default());
    assert!(!page.contains("Largest distance from the target") && !page.contains("tolerances alone"));
    assert!(page.contains("Goal: ") && !page.contains("- ±"));
}

#[test]
fn a_report_is_read_back_as_it_was_written() {
    let stored = slipgrid_results::json(&report()).unwrap();
    assert_eq!(serde_json::from_str::<DesignReport>(&stored).unwrap(), report());
    let [result, _] = slipgrid_results::json_and_timings(&report()).unwrap();
    assert_eq!(serde_json::from_str::<DesignReport>(&result).unwrap(), report());
}

#[test]
fn a_record_without_its_optional_parts_still_makes_a_page() {
    let without = DesignReport {
        chance: None,
        selection: None,
        discrepancy: None,
        conditions: None,
        goal: None,
        sensitivities: None,
        robustness: None,
        trade_offs: None,
        explanation: None,
        table: None,
        ..report()
    };
    for report in [without, DesignReport::default()] {
        let page = design(&report, None, &[], &Outputs::default(), None);
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        for absent in [
            "class=\"chance\"",
            "The design was",
            "degrees of freedom",
            "At every condition",
            "Goal:",
            "What a micrometre changes",
            "What samples will do",
            "Trade-offs",
            "out of reach</h2>",
            "Table of",
            "local friction coefficients",
            "The area law: ",
            ">NaN",
        ] {
            assert!(!page.contains(absent), "{absent}");
        }
    }
}

#[test]
fn text_is_escaped_and_loses_its_control_characters_wherever_it_stands() {
    let mut page = page::Page::default();
    let hostile = "<b>&\"\u{7}\n\tc";
    page.title(hostile);
    page.heading(hostile);
    page.paragraph(hostile);
    page.warning(hostile);
    page.list(&[hostile.to_owned()]);
    page.table(hostile, &[hostile], &[vec![hostile.to_owned()]]);
    page.picture("<svg width=\"1\"></svg>", hostile);
    page.folded(hostile, hostile);
    let page = page.finish(hostile, hostile);
    assert_eq!(page.matches("&lt;b&gt;&amp;&quot;\nc").count(), 15, "{page}");
    assert!(!page.contains("<b>") && !page.contains('\u{7}'));
}

#[test]
fn the_section_is_to_scale() {
    let svg = super::section::section(130.0, 370.0, 20.0, None);
    // 1000 um over 760 units: the first cavity from 185 to 315 um, 15.2 units deep.
    assert!(svg.contains("H309.40V86.00H210.60V101.20") || svg.contains("H309.40V76.40H210.60V91.60"), "{svg}");
    assert!(super::section::section(130.0, 370.0, f64::NAN, None).is_empty());
}

#[test]
fn rims_are_drawn_to_scale_where_that_can_be_seen_and_stretched_by_a_number_that_is_said() {
    let drawn = |height_um: f64, profile: RimProfile| {
        let rim = Rim::new(height_um * 1e-6, 100e-6, profile).unwrap();
        super::section::section(130.0, 370.0, 20.0, Some(&rim))
    };
    // 10 um are 7.6 units below the land, 100 um 76 units from the edge at 309.40.
    let flat = drawn(10.0, RimProfile::Flat);
    assert!(
        flat.contains("both axes at one scale<") && flat.contains("H385.40V99.20L309.40 99.20V76.40H210.60"),
        "{flat}"
    );
    assert!(flat.contains("H210.60V99.20L134.60 99.20V91.60"), "{flat}");
    let ramp = drawn(10.0, RimProfile::Ramp);
    assert!(ramp.contains("H385.40V91.60L309.40 99.20V76.40H210.60V99.20L134.60 91.60V91.60"), "{ramp}");
    // The tangents of the parabola meet half-way.
    let round = drawn(10.0, RimProfile::Round);
    assert!(round.contains("H385.40V91.60Q347.40 99.20 309.40 99.20"), "{round}");
    assert!(round.contains("H210.60V99.20Q172.60 99.20 134.60 91.60V91.60"), "{round}");
    // 0.1 um are 0.076 units: a hundred times as high are 7.6.
    let low = drawn(0.1, RimProfile::Flat);
    assert!(low.contains("rims 100 times as high") && low.contains("H385.40V99.20L309.40 99.20"), "{low}");
    let mut report = report();
    report.design.rim = RimReport::of(&Rim::new(1e-7, 1e-5, RimProfile::Round).unwrap());
    let slope = RimSlopeReport { pressure_mpa: 0.65, per_um: -0.9, error_per_um: Some(2e-3), change: None };
    report.sensitivities.as_mut().unwrap().rim = Some(RimSensitivityReport {
        step_um: 0.02,
        block_um: 5.0,
        by_pressure: vec![slope],
        words: "rims are <high>".to_owned(),
        ..RimSensitivityReport::default()
    });
    let page = page_of(&report, &Outputs::default());
    for said in ["-9000.00 ± 20.00", "over 0.02 µm in blocks of 5 µm", "Rims are &lt;high&gt;."] {
        assert!(page.contains(said), "{said}");
    }
    for said in
        ["round rims 0.1 um high, 10 um wide", "rims 100 times as high", "Not modelled: roughening of the surface"]
    {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("recast"));
}
