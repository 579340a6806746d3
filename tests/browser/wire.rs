//! A browser and its messages, for both protocols.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use tungstenite::{Message, WebSocket};

/// Browser with one page, closed when dropped.
pub struct Wire {
    browser: Child,
    _profile: tempfile::TempDir,
    socket: WebSocket<TcpStream>,
    asked: u64,
    /// Beginning of the addresses that the page may ask for.
    own: String,
    /// Unexpected events of the page: network requests, exceptions, and console messages.
    pub complaints: Vec<String>,
}

impl Wire {
    /// Starts the first of `programs` that there is, with the `arguments` for its profile folder; `None` if there is
    /// none. It prints the address of its socket after `listening`; `session` is appended to the address.
    pub fn start(
        programs: &[&str],
        arguments: fn(&Path) -> Vec<String>,
        [listening, session]: [&str; 2],
        own: &str,
    ) -> Option<Self> {
        let profile = tempfile::tempdir().unwrap();
        let mut browser = programs.iter().find_map(|program| {
            let mut command = Command::new(program);
            command.args(arguments(profile.path())).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().ok()
        })?;
        let mut lines = BufReader::new(browser.stderr.take().unwrap()).lines();
        let address =
            lines.find_map(|line| line.unwrap().strip_prefix(listening).map(str::to_owned)).unwrap() + session;
        std::thread::spawn(move || lines.for_each(drop));
        let host = address.strip_prefix("ws://").unwrap().split('/').next().unwrap();
        let (socket, _) = tungstenite::client(&address, TcpStream::connect(host).unwrap()).unwrap();
        let (own, complaints) = (own.to_owned(), Vec::new());
        Some(Self { browser, _profile: profile, socket, asked: 0, own, complaints })
    }

    /// Sends `message` and returns the answer.
    pub fn call(&mut self, mut message: Value) -> Value {
        self.asked += 1;
        message["id"] = self.asked.into();
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let told: Value = serde_json::from_str(&text).unwrap();
            if told["id"] == self.asked {
                assert!(told["error"].is_null(), "{message}: {told}");
                return told["result"].clone();
            }
            self.note(told["method"].as_str().unwrap_or_default(), &told["params"]);
        }
    }

    fn note(&mut self, method: &str, params: &Value) {
        self.complaints.extend(match method {
            "Runtime.exceptionThrown" => Some(params["exceptionDetails"].to_string()),
            "Runtime.consoleAPICalled" => Some(params["args"].to_string()),
            "Log.entryAdded" => Some(params["entry"]["text"].to_string()),
            "log.entryAdded" => Some(params["text"].to_string()),
            "Network.requestWillBeSent" | "network.beforeRequestSent" => {
                let url = params["request"]["url"].as_str().unwrap_or_default();
                (!self.is_allowed(url)).then(|| format!("asked for {url}"))
            }
            _ => None,
        });
    }

    /// Whether the page may ask for `url`. A file asks for itself alone.
    fn is_allowed(&self, url: &str) -> bool {
        let is_own = url.starts_with(&self.own) && (!url.starts_with("file://") || url.ends_with(".html"));
        is_own || url.starts_with("data:") || url.starts_with("blob:")
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}
