use super::effects::less_known;
use super::*;
use slipgrid_infer::discrepancy::{Conditions, Features, Hyperparameters, Load, Measured, Sensitivity, Trial};
use slipgrid_model::pattern::{Pattern, Planform};

fn trial(name: &str, spacing_um: f64, excess: f64) -> Trial {
    let pattern = Pattern::new(Planform::Groove, 100e-6, spacing_um * 1e-6, 10e-6).unwrap();
    let at = |pressure_pa: f64| Measured {
        load: Load { pressure_pa, speed_m_s: 2e-3, humidity: 0.4 },
        measured: 0.9 * excess.exp(),
        modelled: 0.9,
        patterned_std: 0.005,
        flat_std: 0.005,
        sensitivity: Sensitivity::of_modulus(0.1),
    };
    Trial {
        name: name.to_owned(),
        features: Features::from(&pattern),
        sample_std: None,
        disc: None,
        measured: vec![at(1e6), at(2e6)],
        dimensions_std_m: [0.0; 3],
        dimension_shifts: Vec::new(),
    }
}

fn ledger(trials: Vec<Trial>) -> TrialsReport {
    let learned = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.2, trials).unwrap();
    TrialsReport::new("a <polymer>", &[], &[], &learned, &slipgrid_base::monitor::Unwatched).unwrap()
}

#[test]
fn the_ledger_says_what_was_predicted_and_what_is_known() {
    // Discrepancies in proportion to the areal density: 0.2, 0.1 and 0.05.
    let trials = [("A \"1\"", 400.0, -0.2), ("B", 900.0, -0.1), ("C", 1900.0, -0.05)];
    let found = ledger(trials.map(|(name, spacing_um, excess)| trial(name, spacing_um, excess)).to_vec());
    let text = found.text();
    assert!(
        text.contains("3 trials with 6 measured ratios")
            && text.contains(
                "of 4 within 68 %, 4 within 95 %; 2 ratios are not counted, because no other measurement says"
            ),
        "{text}"
    );
    // The prediction for the third trial is far narrower than that for the first.
    let width = |trial: usize| {
        let [low, high] = found.trials[trial].measured[0].before.interval_95;
        (high / low).ln()
    };
    assert!(width(2) < 0.2 * width(0), "{} {}", width(0), width(2));
    let lines: Vec<String> = found.csv().lines().map(str::to_owned).collect();
    assert_eq!(lines.len(), 7);
    assert!(lines[1].starts_with("\"A \"\"1\"\"\",\"\",0.2,"), "{}", lines[1]);
    let columns = |line: &String| line.matches(',').count();
    assert!(lines.iter().all(|line| columns(line) == columns(&lines[0])));
    let outputs = found.files(&FrictionSheet::default()).unwrap();
    assert_eq!(
        outputs.names(),
        [
            "trials.csv",
            "trials.svg",
            "result.json",
            "timings.json",
            "friction-sheet.md",
            "result.jsonld",
            "report.html"
        ]
    );
    let page = outputs.text("report.html").unwrap();
    for text in [
        "4 of 4 measured ratios",
        "The first sample's 2 ratios are not counted",
        "a &lt;polymer&gt;: trials",
        "What to measure next",
        "<svg role=\"img\"",
        "400.0",
        "1900.0",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let json = serde_json::to_string(&found).unwrap();
    assert_eq!(serde_json::from_str::<TrialsReport>(&json).unwrap(), found);
}

#[test]
fn one_texture_predicts_nothing_and_tells_no_form() {
    // The texture is so dense that some forms predict implausibly large effects.
    let found = ledger(vec![trial("A", 130.0, -0.05)]).with_warnings(vec!["measured ratio: odd".to_owned()]);
    assert!(found.one_texture && found.identified.is_none(), "{:?}", found.forms);
    assert_eq!((found.coverage[0].ratios, found.coverage[0].without_any, found.coverage[0].within_95), (0, 2, 0));
    let text = found.text();
    assert!(
        text.contains("\n! measured ratio: odd\n")
            && text.contains("one texture does not tell whether the error grows with area, edges or depth"),
        "{text}"
    );
    // Two trials that differ by less than a form could tell are no one texture.
    let alike = ledger(vec![trial("A", 130.0, -0.05), trial("B", 135.0, -0.05)]);
    assert!(alike.one_texture && alike.text().contains("textures so alike do not tell whether"), "{}", alike.text());
    assert!(text.contains("surprise, std: number of standard deviations by which"), "{text}");
    assert!(text.contains("predicted by the trials before it: 2 ratios are not counted, because no other measurement says anything of what the model lacks there\n"), "{text}");
    // The measured condition nearest to 1.5 MPa in logarithms.
    assert!(text.contains("the last trial, 2.00 MPa, 2 mm/s, 40 %"), "{text}");
    let page = found.files(&FrictionSheet::default()).unwrap().text("report.html").unwrap();
    for text in [
        "Doubtful: measured ratio: odd.",
        "nothing was predicted by a trial yet",
        "One texture does not tell whether the error grows with area, edges or depth",
    ] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn samples_of_one_texture_that_contradict_each_other_are_named() {
    let mut c = trial("C", 200.0, 0.0);
    // The difference is largest at the higher pressure.
    c.measured[1].measured *= 1.001;
    let found = ledger(vec![trial("A", 200.0, -0.1), trial("B", 700.0, -0.04), c])
        .with_warnings(vec!["measured ratio: odd".to_owned()]);
    assert_eq!(found.warnings.len(), 2);
    let text = found.text();
    for words in [
        "! measured ratio: odd\n! contradicting samples: \"A\" and \"C\" are of one texture",
        "their ratios over the modelled ones differ by 10 % at 2.00 MPa, 2 mm/s and 40 %, where a scatter of 2.0 % is assumed",
        "scatter of samples of one texture, in ln ratio: 0.02 assumed (sample_std), 0.0",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("less is known"), "{text}");
    assert!(
        found
            .files(&FrictionSheet::default())
            .unwrap()
            .text("report.html")
            .unwrap()
            .contains("Doubtful: contradicting samples: ")
    );
    // Samples that agree cause no contradiction warning.
    let text = ledger(vec![trial("A", 200.0, -0.1), trial("B", 700.0, -0.04), trial("C", 200.0, -0.1)]).text();
    assert!(!text.contains("contradicting"), "{text}");
    // One sample says nothing against the stated scatter, which stands there all the same.
    let text = ledger(vec![trial("A", 200.0, -0.1)]).text();
    let scatter = text.lines().find(|line| {
        line.starts_with("scatter of samples of one texture, in ln ratio: 0.02 assumed (sample_std), 0.0")
    });
    assert!(scatter.is_some_and(|line| line.ends_with(" learned and used")), "{text}");
    let effects = [DiscrepancyEffect { of: "a speed".to_owned(), value: 0.0, std: 0.4, prior_std: 0.2 }];
    assert!(less_known(&effects).starts_with("less is known of a speed than before any trial"));
}

#[test]
fn before_any_trial_there_is_nothing_to_draw() {
    let found = ledger(Vec::new());
    assert!(found.text().contains("no trial was measured") && found.identified.is_none());
    assert_eq!(
        found.files(&FrictionSheet::default()).unwrap().names(),
        ["trials.csv", "result.json", "timings.json", "friction-sheet.md", "result.jsonld", "report.html"]
    );
    assert!((found.effects[0].std - found.effects[0].prior_std).abs() < 1e-12);
}
