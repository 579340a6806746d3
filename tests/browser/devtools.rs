//! A page in headless Chromium, over the DevTools protocol.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use super::{Page, is_allowed};

const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Chromium with one page.
pub struct Chromium {
    browser: Child,
    _profile: tempfile::TempDir,
    socket: WebSocket<TcpStream>,
    session: String,
    asked: u64,
    /// Beginning of the addresses that the page may ask for.
    own: String,
    /// Unexpected events of the page: network requests, exceptions, and console messages.
    complaints: Vec<String>,
}

impl Chromium {
    /// Opens the file at `path`; `None` if there is no browser.
    pub fn open(path: &Path) -> Option<Self> {
        let url = format!("file://{}", path.display());
        Self::open_at(&url, "file://")
    }

    /// Opens `url`; the page may ask for addresses that begin with `own`. `None` if there is no browser.
    pub fn open_at(url: &str, own: &str) -> Option<Self> {
        let profile = tempfile::tempdir().unwrap();
        let mut browser = PROGRAMS.into_iter().find_map(|program| {
            Command::new(program)
                .args([
                    "--headless=new",
                    "--no-sandbox",
                    "--disable-gpu",
                    "--disable-quic",
                    "--no-first-run",
                    "--remote-debugging-port=0",
                ])
                .args(["--window-size=1280,800", "--disable-background-networking"])
                .arg(format!("--user-data-dir={}", profile.path().display()))
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .ok()
        })?;
        let mut lines = BufReader::new(browser.stderr.take().unwrap()).lines();
        let address = lines.find_map(|line| line.unwrap().strip_prefix("DevTools listening on ").map(str::to_owned));
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.unwrap();
        let host = address.strip_prefix("ws://").unwrap().split('/').next().unwrap();
        let (socket, _) = tungstenite::client(&address, TcpStream::connect(host).unwrap()).unwrap();
        let (session, complaints) = (String::new(), Vec::new());
        let own = own.to_owned();
        let mut page = Self { browser, _profile: profile, socket, session, asked: 0, own, complaints };
        let target = page.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attached = page.call("Target.attachToTarget", &json!({ "targetId": target["targetId"], "flatten": true }));
        page.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), &json!({}));
        }
        page.call("Page.navigate", &json!({ "url": url }));
        while page.ask("document.readyState") != "complete" {}
        Some(page)
    }

    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = self.session.as_str().into();
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let told: Value = serde_json::from_str(&text).unwrap();
            if told["id"] == self.asked {
                assert!(told["error"].is_null(), "{method}: {told}");
                return told["result"].clone();
            }
            self.note(&told);
        }
    }

    fn note(&mut self, told: &Value) {
        let params = &told["params"];
        match told["method"].as_str().unwrap_or_default() {
            "Runtime.exceptionThrown" => self.complaints.push(params["exceptionDetails"].to_string()),
            "Runtime.consoleAPICalled" => self.complaints.push(params["args"].to_string()),
            "Log.entryAdded" => self.complaints.push(params["entry"]["text"].to_string()),
            "Network.requestWillBeSent" => {
                let url = params["request"]["url"].as_str().unwrap_or_default();
                if !is_allowed(url, &self.own) {
                    self.complaints.push(format!("asked for {url}"));
                }
            }
            _ => {}
        }
    }

    /// Emulates a reader who prefers the colour scheme `scheme`, "light" or "dark".
    pub fn scheme(&mut self, scheme: &str) {
        let feature = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", &json!({ "features": feature }));
    }

    /// Number of A4 pages of the printed page.
    pub fn printed_pages(&mut self) -> u64 {
        let paper = json!({ "paperWidth": 8.27, "paperHeight": 11.69, "preferCSSPageSize": true });
        let printed = self.call("Page.printToPDF", &paper);
        let data = printed["data"].as_str().unwrap();
        self.ask(&format!("(atob('{data}').match(/\\/Type \\/Page\\b/g) || []).length")).as_u64().unwrap()
    }

    /// Whether a reader of the printed page sees every element of `selector`, of which there is at least one.
    pub fn prints_all(&mut self, selector: &str) -> bool {
        self.call("Emulation.setEmulatedMedia", &json!({ "media": "print" }));
        let seen = self.ask(&format!(
            "(all => all.length > 0 && all.every(own => own.getClientRects().length > 0))([...document.querySelectorAll('{selector}')])"
        ));
        self.call("Emulation.setEmulatedMedia", &json!({ "media": "" }));
        seen == json!(true)
    }

    /// Resizes the window; a narrow one is emulated as that of a phone.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let own = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
        self.call("Emulation.setDeviceMetricsOverride", &own);
    }
}

impl Page for Chromium {
    fn ask(&mut self, expression: &str) -> Value {
        let found = self.call("Runtime.evaluate", &json!({ "expression": expression, "returnByValue": true }));
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
            self.call("Input.dispatchKeyEvent", &own);
        }
    }

    fn click(&mut self, x: f64, y: f64) {
        for kind in ["mousePressed", "mouseReleased"] {
            let own = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", &own);
        }
    }

    fn complaints(&self) -> Vec<String> {
        self.complaints.clone()
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}
