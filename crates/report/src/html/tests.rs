use slipgrid_design::records::TableReport;
use slipgrid_design::results::PatternReport;
use slipgrid_design::{DesignReport, SampleReport};
use slipgrid_model::material::{AreaLaw, LocalFriction};
use slipgrid_model::pattern::{RimProfile, TextureRecord};
use slipgrid_model::springblock::Load;

use super::*;
use crate::Outputs;
use fixture::{goal, lifted, report};

pub(crate) mod fixture;

/// Page of `report`, with coefficients and an area law at two pressures.
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
        let texture = &mut report.sample.design.texture;
        (texture.angle_deg, texture.crossing_angle_deg) = (angle_deg, crossing_angle_deg);
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

#[test]
fn bounds_that_a_texture_rests_on_are_a_next_step() {
    let said = |at_bounds: &[&str]| {
        let at_bounds = at_bounds.iter().map(|bound| (*bound).to_owned()).collect();
        page_of(&DesignReport { advice: "trial".into(), at_bounds, ..report() }, &Outputs::default())
    };
    assert!(said(&["the greatest spacing, 1000 um"]).contains("the texture rests on the greatest spacing, 1000 µm."));
    assert!(!said(&[]).contains("widen the bounds"));
}

/// Tags that are opened but not closed, or closed but not opened.
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
    let levels: Vec<u32> =
        page.match_indices("<h").filter_map(|(at, _)| page[at + 2..].chars().next()?.to_digit(10)).collect();
    assert!(levels.windows(2).all(|pair| pair[1] <= pair[0] + 1) && levels.contains(&3), "{levels:?}");
    for said in [
        "<h1>a &lt;b&gt; &amp; &quot;c&quot;</h1>",
        "<p class=\"date\">2026-11-22</p>",
        "<p class=\"headline\">Cut a trial: 16 % chance that a cut sample is on target.</p>",
        "aria-label=\"16 % chance that a cut sample is on target\"",
        "<li><a href=\"#doubts\">at 2.6 MPa cavities close</a></li>",
        "At 2.6 MPa a cut sample is expected to have a ratio to flat friction of 0.791 (95 % of samples: 0.702 to 0.880). Accepted: 0.820 to 0.840.",
        "<a href=\"process.toml\">process.toml</a>",
        "<th scope=\"row\">time under the laser</th><td>13.0 s</td>",
        "model error<small> known from one trial; without it: 40 % chance</small>",
        "<div style=\"width:100.0%\"></div></div><b>0.040</b>",
        "accepted: half the width of the target",
        "the altitude map is synthetic, not measured",
        "<li>1 trial</li>",
        "<li>Young's modulus known to 8.0 %</li>",
        "not modelled: recast rims, plasticity",
        ">expected</button>",
        ">model alone</button>",
        "<td>0.832 ± 0.012</td>",
        "<td>0.702 to 0.880</td>",
        "<td>0.820 to 0.840</td>",
        "<td>-3.50</td>",
        "<td>40 %</td>",
        "0.791 (0.702 to 0.880)",
        "1820 nodes, 3 of them without an answer) compared 4321 designs",
        "Not beaten by another in every goal: 7 of 40 designs",
        "<td>0.9637 ± 0.0002</td>",
        "<td>no_onset</td>",
        "<td>0.3100</td>",
        "standard deviation of 5.0 %",
        "The material is doubtful: spikes: 5 points stand alone.",
        "At 2.6 MPa cavities close",
        "<a href=\"scene.toml\">scene.toml</a>: the confirming run, for slipgrid simulate",
        "Add it as [[trial]] to the calibration of this material.",
        "Make the material file anew: slipgrid calibrate",
        "prefers-color-scheme:dark",
        "@media print",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // The smallest input is not drawn, but appears in the table.
    assert!(page.contains("<td class=\"words\">numerical error") || page.contains("<td>numerical error</td>"));
    assert!(!page.contains("numerical error<small>"));
    // Columns without a value are left out.
    assert!(page.contains(">mu flat</button>") && !page.contains(">mu static</button>"));
    // The list of all doubts, the gravest first, is not folded.
    let doubts = &page[page.find("<ul id=\"doubts\"").unwrap()..];
    let places = ["cavities close", "5 points stand alone", "the floor is 4.1"].map(|words| doubts.find(words));
    assert!(places.is_sorted() && !places.contains(&None), "{places:?}");
    assert_eq!(page[..page.find("<ul id=\"doubts\"").unwrap()].matches("<details").count(), 0);
    // Ids of different pictures are distinct, and nothing is fetched.
    assert_eq!(page.matches("-frame\"/><g clip-path").count(), 3);
    assert!(!page.contains("\"frame\"") && !page.contains("url(#frame)"));
    let bare = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!bare.contains("http") && !bare.contains("src=") && !bare.contains("@import"));
    assert_eq!(page, page_of(&report(), &outputs));
}

#[test]
fn the_page_says_what_the_text_says() {
    let found = report();
    let (page, text) = (page_of(&found, &Outputs::default()), found.summary());
    assert!(text.contains(&found.words) && page.contains(&found.words[1..]), "{text}");
    for doubt in found.doubts() {
        assert!(text.contains(&doubt), "{doubt}");
        // A sentence on the page may have another unit symbol and another case of the first letter.
        let words = super::page::micrometres(doubt[1..].trim_end_matches('.'));
        assert!(page.contains(&words), "{doubt}");
    }
}

#[test]
fn a_load_beyond_those_measured_stands_before_what_is_expected() {
    let mut found = report();
    assert!(!found.summary().contains("outside the measured range"));
    found.confirmed[1].friction_extrapolated = true;
    found.measured_mpa = Some([0.7, 1.4]);
    let text = found.summary();
    let said = "\n! at 2.6 MPa outside the measured range: the nearest measurement's coefficients were taken (friction was measured from \
                0.7 to 1.4 MPa)\n";
    let (place, table) = (text.find(said).unwrap_or_else(|| panic!("{text}")), text.find("95 % of samples").unwrap());
    assert!(place < table && text.matches("outside the measured range").count() == 1, "{text}");
    assert!(page_of(&found, &Outputs::default()).contains("outside the measured range"));
}

#[test]
fn a_goal_alone_has_neither_chance_nor_tolerance() {
    let mut report = report();
    report.goal = Some(goal());
    let count = report.target.pressure_mpa.len();
    report.target = slipgrid_design::records::TargetReport {
        value: None,
        tolerance: None,
        lowest: vec![None; count],
        highest: vec![None; count],
        ..report.target
    };
    report.sample.chance = None;
    for at in &mut report.sample.expected {
        (at.target_low, at.target_high) = (None, None);
    }
    let page = page_of(&report, &Outputs::default());
    assert!(page.contains(
        "Goal: the least standard deviation of the ratio over its mean. Expected 0.1000, model alone 0.1100."
    ));
    for absent in [">accepted<", "against what is accepted", "without it: ", "class=\"odds\"", "Accepted:"] {
        assert!(!page.contains(absent), "{absent}");
    }
    assert!(page.contains("What limits it"));
}

#[test]
fn a_target_out_of_reach_is_marked_and_says_what_keeps_it_there() {
    let mut report = report();
    (report.advice, report.blocked_by) = ("cannot_be_met".into(), vec![lifted()]);
    let page = page_of(&report, &Outputs::default());
    assert!(page.contains("class=\"decision missed\""));
    assert!(page.contains("<li>Without the smallest land, 80 µm: 35 % chance, 40 / 60 / 10 µm.</li>"), "{page}");
    assert!(!page.contains("What to cut") && page.contains("The likeliest texture"));
    assert!(page.contains("<li>Cut nothing for this target yet.</li>"));
    let missed = "Or cut the texture on this page as a trial: it shows how far the model is off there.";
    assert!(page.contains(missed), "{page}");
    report.blocked_by[0].is_within_reach = false;
    assert!(page_of(&report, &Outputs::default()).contains("40 / 60 / 10 µm, still out of reach."));
}

#[test]
fn further_conditions_have_rows_of_their_own() {
    let mut report = report();
    assert!(!page_of(&report, &Outputs::default()).contains(">speed, humidity, direction<"));
    let further: Vec<_> =
        report.sample.expected.iter().map(|at| slipgrid_design::Expected { humidity_pct: 80.0, ..*at }).collect();
    report.sample.expected.extend(further);
    report.sample.modelled.extend(report.sample.modelled.clone());
    let page = page_of(&report, &Outputs::default());
    assert!(page.contains(">speed, humidity, direction<") && page.contains("<td>2 mm/s, 80 %</td>"));
    assert!(page.contains("several conditions, side by side") && page.contains("expected, 2 mm/s, 80 %"));
    // With a target of friction, the model alone is the ratio times flat friction of each condition.
    report.target.quantity = "mu_dynamic".into();
    report.sample.modelled.iter_mut().zip([0.25, 0.25, 0.3, 0.3]).for_each(|(at, flat)| at.flat = flat);
    let page = page_of(&report, &Outputs::default());
    assert!(page.contains("<td>0.240 ± 0.003</td>") && page.contains("<td>0.288 ± 0.004</td>"), "{page}");
}

#[test]
fn a_report_is_read_back_as_it_was_written() {
    let stored = slipgrid_design::results::json(&report()).unwrap();
    assert_eq!(serde_json::from_str::<DesignReport>(&stored).unwrap(), report());
    let [result, _] = slipgrid_design::results::json_and_timings(&report()).unwrap();
    assert_eq!(serde_json::from_str::<DesignReport>(&result).unwrap(), report());
}

#[test]
fn a_record_without_its_optional_parts_still_makes_a_page() {
    let without = DesignReport {
        sample: SampleReport { chance: None, limited_by: Vec::new(), ..report().sample },
        goal: None,
        others: Vec::new(),
        slopes: Vec::new(),
        trade_offs: None,
        table: TableReport::default(),
        ..report()
    };
    for report in [without, DesignReport::default()] {
        let page = design(&report, None, &[], &Outputs::default(), None);
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        for absent in [
            "class=\"bar\"",
            "What limits",
            "Other textures",
            "Goal:",
            "Trade-offs",
            "where one dimension grows",
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
    page.marked("warning", hostile);
    page.list(&[hostile.to_owned()]);
    let mut table = slipgrid_design::results::Table::new([hostile]);
    table.row([hostile.to_owned()]);
    page.table(hostile, &table);
    page.picture("<svg width=\"1\"></svg>", hostile);
    let page = page.finish(hostile, hostile);
    assert_eq!(page.matches("&lt;b&gt;&amp;&quot;\nc").count(), 13, "{page}");
    assert!(!page.contains("<b>") && !page.contains('\u{7}'));
}

#[test]
fn the_section_is_to_scale() {
    let drawn = |depth_um, is_labelled| {
        let design = PatternReport { depth_um, texture: TextureRecord::default(), ..report().sample.design };
        super::section::section(&design, is_labelled)
    };
    let svg = drawn(20.0, true);
    // 1000 um over 760 units: the first cavity from 185 to 315 um, 15.2 units deep.
    assert!(svg.contains("H309.40V86.00H210.60V101.20") || svg.contains("H309.40V76.40H210.60V91.60"), "{svg}");
    assert!(drawn(f64::NAN, true).is_empty());
    let bare = drawn(20.0, false);
    assert!(!bare.contains("<text") && bare.contains("H309.40"), "{bare}");
}

#[test]
fn rims_are_drawn_to_scale_where_that_can_be_seen_and_stretched_by_a_number_that_is_said() {
    let drawn = |height_um: f64, profile: RimProfile| {
        let (height, width, profile) = (Some(height_um), Some(100.0), Some(profile.name().to_owned()));
        let texture = TextureRecord {
            rim_height_um: height,
            rim_width_um: width,
            rim_profile: profile,
            ..TextureRecord::default()
        };
        super::section::section(&PatternReport { texture, ..report().sample.design }, true)
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
    let rims = (Some(0.1), Some(10.0));
    let texture = &mut report.sample.design.texture;
    (texture.rim_height_um, texture.rim_width_um) = rims;
    let page = page_of(&report, &Outputs::default());
    for said in
        ["round rims 0.1 µm high, 10 µm wide", "rims 100 times as high", "Not modelled: roughening of the surface"]
    {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("recast"));
}
