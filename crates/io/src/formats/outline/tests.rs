use super::*;
use crate::formats::source::in_memory;

fn drawing(name: &str, text: &str, layer: Option<&str>) -> Result<Polygon, Diagnostic> {
    read_drawing(&in_memory(&[(name, text.as_bytes())]), Path::new(name), layer)
}

fn svg(body: &str) -> Result<Polygon, Diagnostic> {
    drawing(
        "a.svg",
        &format!("<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\">\n{body}\n</svg>\n"),
        None,
    )
}

fn dxf(entities: &str, layer: Option<&str>) -> Result<Polygon, Diagnostic> {
    drawing("a.dxf", &format!("999\nby hand\n  0\nSECTION\n  2\nENTITIES\n{entities}  0\nENDSEC\n  0\nEOF\n"), layer)
}

/// A polyline of R12.
fn polyline(layer: &str, flags: u8, points: &[[f64; 3]]) -> String {
    let vertex = |[x, y, bulge]: &[f64; 3]| format!("  0\nVERTEX\n  8\n{layer}\n 10\n{x}\n 20\n{y}\n 42\n{bulge}\n");
    let vertices: String = points.iter().map(vertex).collect();
    format!("  0\nPOLYLINE\n  8\n{layer}\n 66\n1\n 70\n{flags}\n{vertices}  0\nSEQEND\n  8\n{layer}\n")
}

const TRIANGLE: [[f64; 2]; 3] = [[0.0, 0.0], [4.0, 0.0], [1.0, 3.0]];

#[test]
fn the_same_outline_comes_from_every_kind_of_drawing() {
    let expected = Polygon::new(&TRIANGLE).unwrap();
    for body in [
        // y points down.
        "<path d=\"M0,0L4 0 1-3z\"/>",
        "<path d=\"m 10 10 h4 l-3,-3 Z\" fill=\"red\"/>",
        "<g id=\"a\"><path d='M0 0H4V0L1 -3L0 0'/></g>",
        "<path d=\"M.0.0 4 0C3-1 2-2 1-3Q.5-1.5 0 0\"/>",
        "<polygon points=\"0,0 4,0 1,-3\"/>",
    ] {
        let found = svg(body).unwrap();
        // Straight Bezier curves are one chord.
        assert_eq!(found, expected, "{body}");
    }
    let corners = TRIANGLE.map(|[x, y]| [x, y, 0.0]);
    let closed = polyline("CAVITY", 1, &corners);
    let other = polyline("FRAME", 1, &[[0.0; 3], [9.0, 0.0, 0.0], [9.0, 9.0, 0.0]]);
    assert_eq!(dxf(&closed, None).unwrap(), expected);
    assert_eq!(dxf(&format!("{other}{closed}"), Some("CAVITY")).unwrap(), expected);
    assert_eq!(dxf(&polyline("0", 0, &[corners.as_slice(), &[corners[0]]].concat()), None).unwrap(), expected);
    let light = "  0\nLWPOLYLINE\n  8\nA\n 90\n3\n 70\n1\n 10\n0\n 20\n0\n 10\n4\n 20\n0\n 10\n1\n 20\n3\n";
    assert_eq!(dxf(light, Some("A")).unwrap(), expected);
    assert_eq!(
        drawing(
            "a.dxf",
            &format!("0\r\nSECTION\r\n2\r\nENTITIES\r\n{}0\r\nEOF\r\n", light.replace('\n', "\r\n")),
            None
        )
        .unwrap(),
        expected
    );
}

#[test]
fn curves_are_flattened_to_the_stated_tolerance() {
    let circle = std::f64::consts::FRAC_PI_4;
    // A chord that deviates by s of the diameter removes 2/3 s of its length: at most 8/3 s of the area.
    let near = |outline: Polygon, area: f64| {
        let short = 1.0 - outline.area() / area;
        assert!((0.0..3.0 * FLATTENING).contains(&short) && outline.vertices().len() < 400, "{short}");
    };
    near(svg("<circle cx=\"5\" cy=\"7mm\" r=\"3\"/>").unwrap(), circle);
    near(svg("<path d=\"M0 0a1 1 0 012 0a1 1 0 01-2 0\"/>").unwrap(), circle);
    near(dxf("  0\nCIRCLE\n  8\nA\n 10\n1\n 20\n2\n 40\n0.065\n", Some("A")).unwrap(), circle);
    near(dxf(&polyline("A", 1, &[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0]]), None).unwrap(), circle);
    // A half disc, its arc below from a positive bulge; three quarters of a disc and the triangle between its ends.
    let half = dxf(&polyline("A", 1, &[[0.0, 0.0, 1.0], [2.0, 0.0, 0.0]]), None).unwrap();
    near(half, circle / 2.0);
    assert!(
        half.vertices().iter().filter(|[_, y]| *y == half.length() / 2.0).count() == 2
            && (half.length() - 0.5).abs() < FLATTENING
    );
    let most = svg("<path d=\"M1 0A1 1 0 1 1 0-1Z\"/>").unwrap();
    near(most, (0.75 * std::f64::consts::PI + 0.5) / 4.0);
    // An ellipse turned by a quarter equals one with exchanged radii; radii that are too small are enlarged.
    let [turned, swapped] = ["M0 0A3 1 90 1 0 2 0A3 1 90 1 0 0 0", "M0 0A1 3 0 1 0 2 0A1 3 0 1 0 0 0"]
        .map(|d| svg(&format!("<path d=\"{d}\"/>")).unwrap());
    assert!((turned.length() - 3.0).abs() < 1e-3 && (turned.area() - swapped.area()).abs() < 1e-9);
    near(svg("<path d=\"M0 0A.1.1 0 1 1 2 0A.1.1 0 1 1 0 0\"/>").unwrap(), circle);
    // Four cubics approximate the circle to 3e-4 of its radius.
    let k = 4.0 / 3.0 * (2_f64.sqrt() - 1.0);
    let round = format!("M1 0C1 {k} {k} 1 0 1S",);
    assert!(svg(&format!("<path d=\"{round}-1 {k} -1 0z\"/>")).unwrap_err().to_string().contains("M L H V C Q A Z"));
    let cubics = format!("M1 0C1 {k} {k} 1 0 1C-{k} 1-1 {k}-1 0C-1-{k}-{k}-1 0-1C{k}-1 1-{k} 1 0");
    assert!((svg(&format!("<path d=\"{cubics}\"/>")).unwrap().area() / circle - 1.0).abs() < 5e-4);
}

#[test]
fn what_is_refused_names_line_key_value_and_what_is_accepted() {
    let triangle = "<polygon points=\"0,0 4,0 1,-3\"/>";
    for (body, says) in [
        ("", &["a.svg: holds no closed outline", "expected one closed path, polygon, rect or circle"][..]),
        (&format!("{triangle}\n{triangle}"), &["a.svg:4: holds 2 closed outlines", "no holes"]),
        ("<path d=\"M0 0H4V4z M1 1H2V2z\"/>", &["a.svg:3: path.d: M has a second subpath", "no holes"]),
        ("<path d=\"M0 0H4V4\"/>", &["a.svg:3: is not closed", "Z"]),
        ("<path d=\"M0 0T4 4z\"/>", &["path.d: T is a command that is not read", "M L H V C Q A Z"]),
        ("<path d=\"L4 4z\"/>", &["path.d: L begins without M"]),
        ("<path d=\"M0 0L4 x\"/>", &["a.svg:3: path.d: x is where a number should stand"]),
        ("<path d=\"M0 0A1 1 0 2 0 4 4z\"/>", &["is where a flag, 0 or 1, should stand"]),
        ("<path d=\"M0 0L1e999 0 1 1z\"/>", &["is no finite number"]),
        ("<path/>", &["is a path without d"]),
        ("\n<circle cx=\"1\" r=\"1em\"/>", &["a.svg:4: circle.r: 1em is no number", "mm or px"]),
        ("<rect width=\"3\" height=\"2\" rx=\"1\"/>", &["is a rect with round corners"]),
        ("<g transform=\"scale(2)\"><circle r=\"1\"/></g>", &["a.svg:3: transform: scale(2) is a transformation"]),
        ("<polyline points=\"0,0 1,1\"/>", &["is a polyline", "expected one closed path"]),
        ("<path d=\"M0 0L2 2L2 0L0 1z\"/>", &["a.svg:3: the edges", "does not cross or touch itself"]),
        ("<path d=\"M0 0H4z\"/>", &["a.svg:3", "at least 3"]),
        ("<rect width=\"3\" height=\"0\"/>", &["a.svg:3", "encloses no area"]),
        ("<path d=\"", &["is no XML"]),
    ] {
        let refused = svg(body).unwrap_err().to_string();
        assert!(says.iter().all(|says| refused.contains(says)), "{body}: {refused}");
    }
    let corners = TRIANGLE.map(|[x, y]| [x, y, 0.0]);
    let closed = polyline("B", 1, &corners);
    for (text, layer, says) in [
        ("", None, &["holds no closed outline", "text DXF"][..]),
        (&closed, Some("A"), &["a.dxf: layer: A holds nothing on that layer, but on B"]),
        (&format!("{closed}{closed}"), None, &["a.dxf:", "holds 2 closed outlines"]),
        (&polyline("B", 0, &corners), None, &["a.dxf:8: is a POLYLINE that is not closed"]),
        (&polyline("B", 9, &corners), None, &["group 70: 9 is a fitted curve"]),
        ("  0\nLINE\n  8\nB\n 10\n0\n", None, &["a.dxf:8: group 0: LINE is no closed outline"]),
        ("  0\nCIRCLE\n 10\n0\n 20\n0\n", None, &["CIRCLE without group 40"]),
        ("  0\nCIRCLE\n 10\n0\n 20\nnan\n 40\n1\n", None, &["a.dxf:12: group 20: nan is no finite number"]),
        ("zero\nCIRCLE\n", None, &["a.dxf:7: group: zero is no group code", "each on a line of its own"]),
        ("  0\nPOLYLINE\n 70\n1\n", None, &["is a POLYLINE without SEQEND"]),
    ] {
        let refused = dxf(text, layer).unwrap_err().to_string();
        assert!(says.iter().all(|says| refused.contains(says)), "{text}: {refused}");
    }
    let refused = |text: &str| drawing("a.dxf", text, None).unwrap_err().to_string();
    assert!(refused("AutoCAD Binary DXF\r\n\u{1a}\0").contains("binary DXF"));
    assert!(refused("0\nSECTION\n").contains("ends before EOF"));
    assert!(refused("0\nSECTION\n2\n").contains("has no value after it"));
    assert!(drawing("a.svg", "<html/>", None).unwrap_err().to_string().contains("is no SVG drawing"));
    let missing = read_drawing(&in_memory(&[]), Path::new("b.svg"), None);
    assert!(missing.unwrap_err().to_string().contains("b.svg: cannot be read"));
}

#[test]
fn lines_of_long_drawings_are_counted_right() {
    // Milliseconds; where lines are counted from the beginning for each element, 20 s.
    let metadata = "<metadata>some text</metadata>\n".repeat(20_000);
    let refused = svg(&format!("{metadata}<line/>")).unwrap_err().to_string();
    assert!(refused.starts_with("a.svg:20003: is a line"), "{refused}");
    let nested = format!("{}\n<path d=\"M0 0H4L1 3Z\"/>{}", "<g>".repeat(20_000), "</g>".repeat(20_000));
    assert!(svg(&nested).is_ok());
    let vertices = "  0\nVERTEX\n  8\nB\n".repeat(20_000);
    assert!(dxf(&vertices, Some("A")).is_err());
}
