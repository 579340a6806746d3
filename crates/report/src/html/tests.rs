use serde_json::json;

use super::*;
use crate::Outputs;

fn result() -> serde_json::Value {
    json!({
        "name": "a <b> & \"c\"", "version": "0.0.0", "status": "met", "section_model": false,
        "chance": {"value": 0.16, "words": "16 % chance that a cut sample is on target (limited by Young's modulus)",
            "included": ["width"], "not_known": ["the model"], "parts": [{"input": "width", "known_to": "8 um", "chance_without": 0.2}]},
        "selection": {"words": "chosen of 3"},
        "design": {"planform": "groove", "width_um": 130.0, "spacing_um": 370.0, "depth_um": 20.0, "areal_density": 0.26},
        "target": {"quantity": "ratio", "pressure_mpa": [0.65, 2.6], "value": [0.97, 0.83], "tolerance": 0.01},
        "predicted": [{"peak_pressure_mpa": 1.9, "ratio_discretization_error": -0.0012}, {"peak_pressure_mpa": 7.1}],
        "predicted_value": [0.9616, 0.8315],
        "confirmed": [
            {"pressure_mpa": 0.65, "ratio": 0.9637, "ratio_stderr": 0.0002, "mu_dynamic": 0.24, "mu_flat": 0.25, "status": "converged"},
            {"pressure_mpa": 2.6, "ratio": 0.8355, "ratio_stderr": 0.0008, "mu_dynamic": 0.23, "cavity_closed": true, "status": "converged"}
        ],
        "errors": {"meaning": "+-: one standard deviation of time", "includes": ["time"], "by_pressure": [
            {"pressure_mpa": 0.65, "predicted": {"value": 0.9616, "std": 0.0012}, "ratio": {"value": 0.9637, "std": 0.0002},
             "mu": {"value": 0.24, "std": null}, "mu_flat": {"value": 0.25, "std": 0.002}},
            {"pressure_mpa": 2.6, "predicted": {"value": 0.8315, "std": null},
             "ratio": {"value": 0.8355, "std": 0.0008, "parts": [{"input": "time", "std": 0.0007}]}, "mu": {"value": null, "std": null}}
        ]},
        "discrepancy": {"used": false, "pattern": "squares", "degrees_of_freedom": 5, "misfit": {"physics": 0.8, "with_discrepancy": 17.1},
            "by_pressure": [{"pressure_mpa": 2.6, "factor": 0.829, "relative_std": 0.05, "outside_measured_range": true,
                "confirmed": {"physics": 0.8355, "with_discrepancy": 0.6926}}]},
        "misfit": {"predicted": 0.84, "confirmed": null},
        "sensitivities": {"quantity": "ratio", "step_um": {"width": 5.0, "spacing": 5.0, "depth": null}, "by_pressure": [
            {"pressure_mpa": 0.65, "per_um": {"width": -3.5e-4, "spacing": 1.2e-4, "depth": null},
             "error_per_um": {"width": 2e-6, "spacing": 0.0, "depth": null}}]},
        "robustness": {"method": "sampled", "meaning": "of a mean",
            "inputs": [{"name": "width", "std": [8.0], "unit": "um", "basis": "b"}],
            "samples": {"draws": 1000, "failed": 3, "redrawn": 0, "probability": 0.62, "probability_stderr": 0.015, "by_pressure": [
                {"pressure_mpa": 0.65, "ratio": {"band_95": [0.94, 0.98]}, "mu": {"mean": 0.24, "band_95": [0.23, 0.25]}}]},
            "parts": [{"of": [{"input": "width", "std": 0.01}]}],
            "with_discrepancy": {"probability": 0.1, "probability_stderr": 0.01, "factor": [0.85], "by_pressure": []}},
        "history": [{"evaluation": 1, "misfit": 3.0}, {"evaluation": 9, "misfit": 0.5}],
        "material": {"name": "m", "source": "s", "synthetic_surface": true, "notes": ["n"],
            "warnings": ["spikes: 5 points stand alone"]},
        "model": ["two dimensions"], "laser": {"spot_um": 23.0}, "evaluations": 9, "rounds": 1, "seed": 1
    })
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
    let scene = "[material.friction]\nstatic_mean = 0.31\ndynamic_mean = 0.28\nrelative_std = 0.05\n\
        [material.area_law]\npressure_mpa = [0.7, 2.0]\nfactor = [1.0, 0.1]\nfactor_std = [0.0, 0.02]\n";
    outputs.add("design.toml", scene);
    let page = design(&result(), &outputs);
    assert_eq!(unbalanced(&page), Vec::<String>::new());
    for said in [
        "<h1>a &lt;b&gt; &amp; &quot;c&quot;</h1>",
        "<p class=\"chance\">16 % chance that a cut sample is on target (limited by Young's modulus).</p>",
        "<div style=\"width:16.0%\">",
        "Not in the chance, as nothing says how well it is known: the model.",
        "The design was chosen of 3.",
        "Target met by the model.",
        "<td>0.97 ± 0.01</td>",
        "Status at every pressure: converged.",
        "0.9616 ± 0.0012",
        "0.8355 ± 0.0008",
        "one standard deviation of time",
        "<td>0.0007</td>",
        "0.829 ± 0.041 (outside the pressures measured)",
        "<td>0.6926</td>",
        "-3.50 ± 0.02",
        "62.0 ± 1.5 % of samples",
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
        "prefers-color-scheme:dark",
        "@media print",
        "Improvements during the search",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // Columns without a value take no room.
    assert!(page.contains(">mu flat</button>") && !page.contains(">mu static</button>"));
    assert!(!page.contains(">status</button>"));
    let mut differing = result();
    differing["errors"]["by_pressure"][0]["mu_static"] = json!({"value": 0.27, "std": 0.003});
    differing["confirmed"][1]["status"] = json!("no_onset");
    let differing = design(&differing, &outputs);
    assert!(differing.contains(">mu static</button>") && differing.contains("<td>no_onset</td>"));
    assert!(!differing.contains("Status at every"));
    // Names of different pictures do not meet, and nothing is fetched.
    assert!(page.contains("id=\"p1-frame\"") && page.contains("url(#p2-frame)") && !page.contains("\"frame\""));
    let bare = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!bare.contains("http") && !bare.contains("src=") && !bare.contains("@import"));
    assert_eq!(page, design(&result(), &outputs));
}

#[test]
fn a_result_without_its_parts_still_makes_a_page() {
    for result in [json!({}), json!([1, 2]), json!({"target": {"pressure_mpa": [1.0]}, "confirmed": "x", "laser": []})]
    {
        assert_eq!(unbalanced(&design(&result, &Outputs::default())), Vec::<String>::new());
    }
}

#[test]
fn the_section_is_to_scale() {
    let svg = super::section::section(130.0, 370.0, 20.0);
    // 1000 um over 760 units: the first cavity from 185 to 315 um, 15.2 units deep.
    assert!(svg.contains("H309.40V86.00H210.60V101.20") || svg.contains("H309.40V76.40H210.60V91.60"), "{svg}");
    assert!(super::section::section(130.0, 370.0, f64::NAN).is_empty());
}
