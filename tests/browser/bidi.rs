//! A page in headless Firefox, over WebDriver BiDi (https://www.w3.org/TR/webdriver-bidi/).

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use super::{Page, is_allowed};

const PROGRAMS: [&str; 2] = ["firefox-esr", "firefox"];

/// Firefox with one page.
pub struct Firefox {
    browser: Child,
    _profile: tempfile::TempDir,
    socket: WebSocket<TcpStream>,
    context: String,
    asked: u64,
    /// Beginning of the addresses that the page may ask for.
    own: String,
    complaints: Vec<String>,
}

impl Firefox {
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
                .args(["--headless", "--no-remote", "--remote-debugging-port", "0", "--profile"])
                .arg(profile.path())
                .arg("about:blank")
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .ok()
        })?;
        let mut lines = BufReader::new(browser.stderr.take().unwrap()).lines();
        let listening = "WebDriver BiDi listening on ws://";
        let host = lines.find_map(|line| line.unwrap().strip_prefix(listening).map(str::to_owned)).unwrap();
        std::thread::spawn(move || lines.for_each(drop));
        let stream = TcpStream::connect(&host).unwrap();
        let (socket, _) = tungstenite::client(format!("ws://{host}/session"), stream).unwrap();
        let (context, complaints) = (String::new(), Vec::new());
        let own = own.to_owned();
        let mut page = Self { browser, _profile: profile, socket, context, asked: 0, own, complaints };
        page.call("session.new", &json!({ "capabilities": {} }));
        let tree = page.call("browsingContext.getTree", &json!({}));
        page.context = tree["contexts"][0]["context"].as_str().unwrap().to_owned();
        let context = page.context.clone();
        page.call(
            "browsingContext.setViewport",
            &json!({ "context": context, "viewport": { "width": 1280, "height": 800 } }),
        );
        page.call(
            "session.subscribe",
            &json!({ "events": ["log.entryAdded", "network.beforeRequestSent"], "contexts": [context] }),
        );
        page.call("browsingContext.navigate", &json!({ "context": context, "url": url, "wait": "complete" }));
        Some(page)
    }

    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        let message = json!({ "id": self.asked, "method": method, "params": params });
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let told: Value = serde_json::from_str(&text).unwrap();
            if told["id"] == self.asked {
                assert_eq!(told["type"], "success", "{method}: {told}");
                return told["result"].clone();
            }
            self.note(&told);
        }
    }

    fn note(&mut self, told: &Value) {
        let params = &told["params"];
        match told["method"].as_str().unwrap_or_default() {
            "log.entryAdded" => self.complaints.push(params["text"].to_string()),
            "network.beforeRequestSent" => {
                let url = params["request"]["url"].as_str().unwrap_or_default();
                if !is_allowed(url, &self.own) {
                    self.complaints.push(format!("asked for {url}"));
                }
            }
            _ => {}
        }
    }

    fn act(&mut self, actions: &Value) {
        let context = self.context.clone();
        self.call("input.performActions", &json!({ "context": context, "actions": [actions] }));
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
        let found = self.call("script.evaluate", &own);
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
        self.complaints.clone()
    }
}

impl Drop for Firefox {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}
