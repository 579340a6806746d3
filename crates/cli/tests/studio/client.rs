//! A server of the page, and requests to it as any program could send them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::DESIGN;

/// Longest time for an answer or a job.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running server.
pub struct Server {
    child: Child,
    pub port: u16,
    pub token: String,
}

/// Answer of a server.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&self.body)))
    }
}

/// Program with the arguments of a server for `folder`, with a cache of its own.
pub fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slipgrid"));
    command.args(["studio", "--no-browser"]).arg(folder).env("SLIPGRID_CACHE", "");
    command
}

impl Server {
    /// Server for a new folder.
    pub fn anywhere() -> (TempDir, Self) {
        let folder = tempfile::tempdir().unwrap();
        let server = Self::start(folder.path());
        (folder, server)
    }

    /// Server for a folder with [`DESIGN`] in the file quick.toml.
    pub fn with_design() -> (TempDir, Self) {
        let (folder, server) = Self::anywhere();
        std::fs::write(folder.path().join("quick.toml"), DESIGN).unwrap();
        (folder, server)
    }

    pub fn start(folder: &Path) -> Self {
        let mut child = program(folder).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, rest) = line.trim().split_once("http://127.0.0.1:").unwrap_or_else(|| panic!("{line}"));
        let (port, token) = rest.split_once("/?token=").unwrap();
        Self { child, port: port.parse().unwrap(), token: token.to_owned() }
    }

    /// Sends a request with exactly these headers.
    pub fn raw(&self, method: &str, target: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut head = format!("{method} {target} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n", body.len());
        headers.iter().for_each(|(name, value)| head += &format!("{name}: {value}\r\n"));
        stream.write_all(format!("{head}\r\n").as_bytes()).unwrap();
        // A refused request may be answered before its body is read.
        let _ = stream.write_all(body);
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer with a head");
        let head = String::from_utf8(all[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let mut body = all.split_off(end + 4);
        if head.to_lowercase().contains("transfer-encoding: chunked") {
            body = unchunked(&body);
        }
        Answer { status, head, body }
    }

    pub fn cookie(&self) -> String {
        format!("slipgrid_{}={}", self.port, self.token)
    }

    /// Lines of the stream of events, from the first on.
    pub fn events(&self) -> impl Iterator<Item = String> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (port, cookie) = (self.port, self.cookie());
        let head = format!("GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        let mut lines = BufReader::new(stream).lines().map(Result::unwrap);
        assert!(lines.any(|line| line == "event: hello"));
        lines
    }

    /// Sends a request as the page does.
    pub fn ask(&self, method: &str, target: &str, body: &[u8]) -> Answer {
        let (host, cookie) = (format!("127.0.0.1:{}", self.port), self.cookie());
        let headers = [("Host", &host[..]), ("Cookie", &cookie), ("Content-Type", "application/json")];
        self.raw(method, target, &headers, body)
    }

    pub fn get(&self, target: &str) -> Value {
        let answer = self.ask("GET", target, b"");
        assert_eq!(answer.status, 200, "{target}: {}", String::from_utf8_lossy(&answer.body));
        answer.json()
    }

    pub fn send(&self, method: &str, target: &str, body: &Value) -> Value {
        let answer = self.ask(method, target, body.to_string().as_bytes());
        assert_eq!(answer.status, 200, "{target}: {}", String::from_utf8_lossy(&answer.body));
        answer.json()
    }

    /// Runs a job to its end.
    pub fn job(&self, words: &[&str]) -> Value {
        let id = self.send("POST", "/api/jobs", &serde_json::json!({ "command": words }))["id"].clone();
        self.ended(&id)
    }

    /// Waits for the end of a job.
    pub fn ended(&self, id: &Value) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let jobs = self.get("/api/jobs");
            let job = jobs["jobs"].as_array().unwrap().iter().find(|job| job["id"] == *id).unwrap();
            if !["queued", "running"].contains(&job["state"].as_str().unwrap()) {
                return job.clone();
            }
            assert!(Instant::now() < until, "{job}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Ends the server as a crash does.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn unchunked(mut body: &[u8]) -> Vec<u8> {
    let mut all = Vec::new();
    while let Some(end) = body.windows(2).position(|two| two == b"\r\n") {
        let size = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap(), 16).unwrap();
        all.extend(body.iter().skip(end + 2).take(size));
        body = body.get(end + 4 + size..).unwrap_or_default();
    }
    all
}
