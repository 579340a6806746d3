//! Requests that must not be answered: from other sites, without the token, for files outside the folder.

use std::fs;

use serde_json::json;

use crate::client::{Server, program};

#[test]
fn only_the_page_with_its_token_is_answered() {
    let (_folder, server) = Server::anywhere();
    let (host, cookie) = (format!("127.0.0.1:{}", server.port), server.cookie());
    let own = [("Host", &host[..]), ("Cookie", &cookie[..])];
    let status = |headers: &[(&str, &str)]| server.raw("GET", "/api/folder", headers, b"").status;
    assert_eq!(status(&own), 200);
    assert_eq!(status(&[("Host", &host)]), 401);
    assert_eq!(status(&[("Host", &host), ("Cookie", &cookie.replace("=", "=0"))]), 401);
    let with = |name: &str, value: &str| status(&[own[0], own[1], (name, value)]);
    assert_eq!(with("Origin", &format!("http://{host}")), 200);
    for (name, value) in [
        ("Origin", "http://evil.example"),
        ("Origin", "null"),
        ("Origin", &format!("https://{host}")),
        ("Origin", &format!("http://{host}.evil.example")),
        ("Sec-Fetch-Site", "cross-site"),
        ("Sec-Fetch-Site", "same-site"),
    ] {
        assert_eq!(with(name, value), 403, "{name}: {value}");
    }
    // A name that an attacker makes resolve to this computer (DNS rebinding), and no name at all.
    for host in ["evil.example", "127.0.0.1", "127.0.0.1:1", &format!("evil.example:{}", server.port)] {
        assert_eq!(status(&[("Host", host), ("Cookie", &cookie)]), 403, "{host}");
    }
    assert!([400, 403].contains(&status(&[("Cookie", &cookie)])));
    let wrong = server.raw("GET", "/?token=0123", &[("Host", &host)], b"");
    assert_eq!(wrong.status, 401);
    let opened = server.raw("GET", &format!("/?token={}", server.token), &[("Host", &host)], b"");
    assert!(opened.status == 303 && opened.head.contains("HttpOnly; SameSite=Strict"), "{}", opened.head);
    let page = server.raw("GET", "/", &own, b"");
    let policy = "content-security-policy: default-src 'none'; script-src 'self'";
    assert!(page.status == 200 && page.head.contains(policy), "{}", page.head);
}

#[test]
fn no_path_leaves_the_folder() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("folder");
    fs::create_dir(&folder).unwrap();
    fs::write(place.path().join("secret.toml"), "secret = 1\n").unwrap();
    fs::write(folder.join(".hidden.toml"), "secret = 1\n").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(place.path(), folder.join("link")).unwrap();
    let server = Server::start(&folder);
    let files_at = server.get("/api/folder")["files_at"].as_str().unwrap().to_owned();
    for path in [
        "../secret.toml",
        "%2e%2e/secret.toml",
        "/etc/passwd",
        "a/../../secret.toml",
        "link/secret.toml",
        ".hidden.toml",
        "..%5csecret.toml",
    ] {
        if path.starts_with("link") && cfg!(not(unix)) {
            continue;
        }
        let refused = |method: &str, target: &str, body: &str| {
            let answer = server.ask(method, target, body.as_bytes());
            assert!([400, 403, 404].contains(&answer.status), "{method} {target}: {}", answer.status);
            assert!(!String::from_utf8_lossy(&answer.body).contains("secret = 1"), "{target}");
        };
        refused("GET", &format!("/api/text?path={path}"), "");
        refused("PUT", &format!("/api/text?path={path}"), r#"{"text": "gone = 1", "digest": null}"#);
        refused("POST", &format!("/api/edit?path={path}"), r#"{"digest": "", "edits": []}"#);
        refused("PUT", &format!("/api/upload?path={path}"), "gone");
        refused("GET", &format!("/api/trace?path={path}"), "");
        refused("GET", &format!("/api/zip?path={path}"), "");
        refused("GET", &format!("{files_at}{path}"), "");
        let path = path.replace("%2e", ".").replace("%5c", "\\");
        refused("POST", "/api/explore", &json!({ "path": path }).to_string());
        refused("POST", "/api/jobs", &json!({ "command": ["optimize", path] }).to_string());
        refused("POST", "/api/jobs", &json!({ "command": ["new", "design", "-o", path] }).to_string());
    }
    assert_eq!(fs::read_to_string(place.path().join("secret.toml")).unwrap(), "secret = 1\n");
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 2);
    // A key of files reads files, and nothing else.
    let host = format!("127.0.0.1:{}", server.port);
    fs::write(folder.join("a.txt"), "text").unwrap();
    let read = server.raw("GET", &format!("{files_at}a.txt"), &[("Host", &host)], b"");
    assert!(read.status == 200 && read.body == b"text" && read.head.contains("sandbox allow-scripts"));
    assert_eq!(server.raw("GET", "/files/0123/a.txt", &[("Host", &host)], b"").status, 401);
    let foreign = server.raw("GET", &format!("{files_at}a.txt"), &[("Host", "evil.example")], b"");
    assert_eq!(foreign.status, 403);
}

#[test]
fn wrong_requests_are_refused_and_the_page_goes_on() {
    let (_folder, server) = Server::anywhere();
    for (method, target, body) in [
        ("POST", "/api/jobs", "{"),
        ("POST", "/api/jobs", r#"{"command": []}"#),
        ("POST", "/api/jobs", r#"{"command": ["studio", "."]}"#),
        ("POST", "/api/jobs", r#"{"command": ["rm", "-rf", "x"]}"#),
        ("POST", "/api/jobs/99/cancel", ""),
        ("GET", "/api/schema?kind=x", ""),
        ("GET", "/api/nothing", ""),
        ("GET", "/assets/..%2fCargo.toml", ""),
        ("GET", "/api/predict?path=x.toml&width_um=1&spacing_um=a&depth_um=1", ""),
    ] {
        let status = server.ask(method, target, body.as_bytes()).status;
        assert!((400..500).contains(&status), "{method} {target} {body}: {status}");
    }
    let many = vec![b'x'; 4 << 20];
    assert!([400, 413].contains(&server.ask("PUT", "/api/text?path=a.toml", &many).status));
    assert_eq!(server.ask("GET", "/", b"").status, 200);
}

#[test]
fn one_server_works_in_a_folder_and_a_killed_one_leaves_it_free() {
    let (folder, server) = Server::anywhere();
    let second = program(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(second.status.code() == Some(2) && said.contains("another run works for this folder"), "{said}");
    server.kill();
    assert_eq!(Server::start(folder.path()).ask("GET", "/", b"").status, 200);
}
