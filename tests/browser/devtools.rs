//! A page in headless Chromium, over the DevTools protocol.

use std::path::Path;

use serde_json::{Value, json};

use super::Page;
use super::wire::Wire;

const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Chromium with one page.
pub struct Chromium {
    wire: Wire,
    session: String,
}

impl Chromium {
    /// Opens the file at `path`; `None` if there is no browser.
    pub fn open(path: &Path) -> Option<Self> {
        Self::open_at(&format!("file://{}", path.display()), "file://")
    }

    /// Opens `url`; the page may ask for addresses that begin with `own`. `None` if there is no browser.
    pub fn open_at(url: &str, own: &str) -> Option<Self> {
        let arguments = |profile: &Path| {
            let profile = format!("--user-data-dir={}", profile.display());
            let words = "--headless=new --no-sandbox --disable-gpu --disable-quic --no-first-run \
                --remote-debugging-port=0 --window-size=1280,800 --disable-background-networking";
            words.split_whitespace().chain([&*profile]).map(str::to_owned).collect()
        };
        let wire = Wire::start(&PROGRAMS, arguments, ["DevTools listening on ", ""], own)?;
        let mut page = Self { wire, session: String::new() };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = page.call("Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        page.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.call("Page.navigate", json!({ "url": url }));
        while page.ask("document.readyState") != "complete" {}
        Some(page)
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        let mut message = json!({ "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = self.session.as_str().into();
        }
        self.wire.call(message)
    }

    /// Emulates a reader who prefers the colour scheme `scheme`, "light" or "dark".
    pub fn scheme(&mut self, scheme: &str) {
        let feature = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": feature }));
    }

    /// Number of A4 pages of the printed page.
    pub fn printed_pages(&mut self) -> u64 {
        let paper = json!({ "paperWidth": 8.27, "paperHeight": 11.69, "preferCSSPageSize": true });
        let printed = self.call("Page.printToPDF", paper);
        let data = printed["data"].as_str().unwrap();
        self.ask(&format!("(atob('{data}').match(/\\/Type \\/Page\\b/g) || []).length")).as_u64().unwrap()
    }

    /// Whether a reader of the printed page sees every element of `selector`, of which there is at least one.
    pub fn prints_all(&mut self, selector: &str) -> bool {
        self.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
        let seen = self.ask(&format!(
            "(all => all.length > 0 && all.every(own => own.getClientRects().length > 0))([...document.querySelectorAll('{selector}')])"
        ));
        self.call("Emulation.setEmulatedMedia", json!({ "media": "" }));
        seen == json!(true)
    }

    /// Resizes the window; a narrow one is emulated as that of a phone.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let own = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
        self.call("Emulation.setDeviceMetricsOverride", own);
    }
}

impl Page for Chromium {
    fn ask(&mut self, expression: &str) -> Value {
        let found = self.call("Runtime.evaluate", json!({ "expression": expression, "returnByValue": true }));
        assert!(found["exceptionDetails"].is_null(), "{expression}: {found}");
        found["result"]["value"].clone()
    }

    fn press(&mut self, key: &str) {
        let code = match key {
            "Enter" => 13,
            "ArrowLeft" => 37,
            "ArrowRight" => 39,
            other => panic!("{other} is not known here"),
        };
        let text = if key == "Enter" { "\r" } else { "" };
        for kind in [if text.is_empty() { "rawKeyDown" } else { "keyDown" }, "keyUp"] {
            let own = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "text": text });
            self.call("Input.dispatchKeyEvent", own);
        }
    }

    fn click(&mut self, x: f64, y: f64) {
        for kind in ["mousePressed", "mouseReleased"] {
            let own = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", own);
        }
    }

    fn complaints(&self) -> Vec<String> {
        self.wire.complaints.clone()
    }
}
