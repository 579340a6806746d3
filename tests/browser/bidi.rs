//! A page in headless Firefox, over WebDriver BiDi (https://www.w3.org/TR/webdriver-bidi/).

use std::path::Path;

use serde_json::{Value, json};

use super::Page;
use super::wire::Wire;

/// Firefox with one page.
pub struct Firefox {
    wire: Wire,
    context: String,
}

impl Firefox {
    /// Opens the file at `path`; `None` if there is no browser.
    pub fn open(path: &Path) -> Option<Self> {
        Self::open_at(&format!("file://{}", path.display()), "file://")
    }

    /// Opens `url`; the page may ask for addresses that begin with `own`. `None` if there is no browser.
    pub fn open_at(url: &str, own: &str) -> Option<Self> {
        let arguments = |profile: &Path| {
            let profile = profile.display().to_string();
            ["--headless", "--no-remote", "--remote-debugging-port", "0", "--profile", &profile, "about:blank"]
                .map(str::to_owned)
                .into()
        };
        let listening = ["WebDriver BiDi listening on ", "/session"];
        let wire = Wire::start(&["firefox-esr", "firefox"], arguments, listening, own)?;
        let mut page = Self { wire, context: String::new() };
        page.call("session.new", json!({ "capabilities": {} }));
        let tree = page.call("browsingContext.getTree", json!({}));
        page.context = tree["contexts"][0]["context"].as_str().unwrap().to_owned();
        let context = page.context.clone();
        let viewport = json!({ "width": 1280, "height": 800 });
        page.call("browsingContext.setViewport", json!({ "context": context, "viewport": viewport }));
        let events = ["log.entryAdded", "network.beforeRequestSent"];
        page.call("session.subscribe", json!({ "events": events, "contexts": [context] }));
        page.call("browsingContext.navigate", json!({ "context": context, "url": url, "wait": "complete" }));
        Some(page)
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.wire.call(json!({ "method": method, "params": params }))
    }

    fn act(&mut self, actions: &Value) {
        let context = self.context.clone();
        self.call("input.performActions", json!({ "context": context, "actions": [actions] }));
    }
}

impl Page for Firefox {
    fn ask(&mut self, expression: &str) -> Value {
        // As text, so that numbers and lists need no translation.
        let own = json!({
            "expression": format!("JSON.stringify(({expression}) ?? null)"),
            "target": { "context": self.context.clone() },
            "awaitPromise": false,
        });
        let found = self.call("script.evaluate", own);
        assert_eq!(found["type"], "success", "{expression}: {found}");
        serde_json::from_str(found["result"]["value"].as_str().unwrap()).unwrap()
    }

    fn press(&mut self, key: &str) {
        // Keys of https://www.w3.org/TR/webdriver2/#keyboard-actions.
        let value = match key {
            "Enter" => "\u{e006}",
            "ArrowLeft" => "\u{e012}",
            "ArrowRight" => "\u{e014}",
            other => panic!("{other} is not known here"),
        };
        let moves: Vec<Value> = ["keyDown", "keyUp"].map(|kind| json!({ "type": kind, "value": value })).into();
        self.act(&json!({ "type": "key", "id": "keyboard", "actions": moves }));
    }

    fn click(&mut self, x: f64, y: f64) {
        self.act(&json!({ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": [
            { "type": "pointerMove", "x": x.round(), "y": y.round() },
            { "type": "pointerDown", "button": 0 },
            { "type": "pointerUp", "button": 0 },
        ] }));
    }

    fn complaints(&self) -> Vec<String> {
        self.wire.complaints.clone()
    }
}
