//! Files through the page: the folder stays the truth.

use std::fs;

use serde_json::json;

use crate::DESIGN;
use crate::client::Server;

#[test]
fn texts_are_checked_edited_and_never_lost() {
    let (folder, server) = Server::anywhere();
    let target = "/api/text?path=designs/quick.toml";
    let made = server.send("PUT", target, &json!({ "text": DESIGN, "digest": null }));
    assert_eq!([&made["kind"], &made["check"]["errors"]], [&json!("design"), &json!([])]);
    let again = server.ask("PUT", target, json!({ "text": "x = 1", "digest": null }).to_string().as_bytes());
    assert_eq!(again.status, 409);

    // A form changes one value, and keeps comments.
    let edit = json!({ "digest": made["digest"], "edits": [{ "at": ["target", "value"], "value": 0.9 }] });
    let edited = server.send("POST", "/api/edit?path=designs/quick.toml", &edit);
    let path = folder.path().join("designs/quick.toml");
    assert_eq!(fs::read_to_string(&path).unwrap(), DESIGN.replace("value = 0.85", "value = 0.9"));
    assert_eq!(edited["values"]["target"]["value"], 0.9);

    // What another program wrote meanwhile is not overwritten.
    fs::write(&path, DESIGN.replace("quick\"", "changed\"")).unwrap();
    let stale = server.ask("POST", "/api/edit?path=designs/quick.toml", edit.to_string().as_bytes());
    assert_eq!(stale.status, 409);
    assert!(fs::read_to_string(&path).unwrap().contains("changed"));

    // Errors are those of the command line, with their lines.
    let draft = json!({ "text": DESIGN.replace("width_um", "widht_um") });
    let checked = server.send("POST", "/api/check?path=designs/quick.toml", &draft);
    let error = &checked["check"]["errors"][0];
    let line = 1 + DESIGN.lines().position(|line| line.starts_with("width_um")).unwrap();
    assert_eq!(error["line"], line, "{error}");
    assert!(error["message"].as_str().unwrap().contains("widht_um"), "{error}");
    let broken = server.send("POST", "/api/check?path=designs/quick.toml", &json!({ "text": "a = \n[" }));
    assert_eq!(broken["check"]["errors"][0]["line"], 1, "{broken}");
    assert!(broken["values"].is_null());
}

#[test]
fn uploads_never_replace_a_file() {
    let (folder, server) = Server::anywhere();
    let target = "/api/upload?path=m/traces/flat-1.csv";
    let text = b"time,fx,fz\n0,1,2\n";
    let made = server.ask("PUT", target, text);
    assert_eq!(made.json(), json!({ "path": "m/traces/flat-1.csv", "kind": "table" }));
    assert_eq!(server.ask("PUT", target, text).status, 200);
    assert_eq!(server.ask("PUT", target, b"other").status, 409);
    assert_eq!(fs::read(folder.path().join("m/traces/flat-1.csv")).unwrap(), text);
    let large = vec![b'7'; 100 << 20];
    assert_eq!(server.ask("PUT", "/api/upload?path=map.asc", &large).status, 200);
    assert_eq!(fs::metadata(folder.path().join("map.asc")).unwrap().len(), 100 << 20);
    let listed = server.get("/api/folder");
    let names: Vec<_> = listed["files"].as_array().unwrap().iter().map(|file| file["path"].clone()).collect();
    assert_eq!(names, ["m/traces/flat-1.csv", "map.asc"]);
}

#[test]
fn the_schemas_describe_every_form() {
    let (_folder, server) = Server::anywhere();
    for kind in ["calibration", "design", "material", "scene", "campaign"] {
        assert!(server.get(&format!("/api/schema?kind={kind}"))["properties"].is_object());
    }
}
