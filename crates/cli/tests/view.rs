//! `zonal view` as a process: answers, refused requests, and its end.
#![cfg(unix)]

use crate::support;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use support::{Folder, Program, refused, solution, text};

/// A running viewer of the small room; killed when dropped.
struct RunningViewer {
    folder: Folder,
    child: Child,
    address: SocketAddr,
    output: BufReader<std::process::ChildStdout>,
}

impl RunningViewer {
    fn start() -> RunningViewer {
        RunningViewer::of("room.npz", solution())
    }

    /// Shows a file.
    fn of(name: &str, content: impl AsRef<[u8]>) -> RunningViewer {
        let folder = Folder::new();
        folder.put(name, content);
        let mut child = Command::new(env!("CARGO_BIN_EXE_zonal"))
            .args(["view", name, "--port", "0"])
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        output.read_line(&mut line).unwrap();
        let url = line.trim().rsplit(' ').next().unwrap().to_string();
        let address = url.strip_prefix("http://").unwrap().trim_end_matches('/').parse().unwrap();
        RunningViewer { folder, child, address, output }
    }

    fn connect(&self) -> TcpStream {
        let s = TcpStream::connect(self.address).unwrap();
        s.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        s.set_write_timeout(Some(Duration::from_secs(20))).unwrap();
        s
    }

    /// Sends bytes and reads the answer.
    fn send(&self, bytes: &[u8]) -> String {
        let mut s = self.connect();
        // The server may close the connection before everything is sent.
        let _ = s.write_all(bytes);
        let _ = s.shutdown(std::net::Shutdown::Write);
        let mut out = Vec::new();
        let _ = s.read_to_end(&mut out);
        text(&out)
    }

    fn get(&self, target: &str) -> String {
        self.send(format!("GET {target} HTTP/1.1\r\nHost: {}\r\n\r\n", self.address).as_bytes())
    }

    fn assert_responsive(&self) {
        assert!(self.get("/").starts_with("HTTP/1.1 200 OK\r\n"));
    }

    /// Sends a signal; returns the exit code and the remaining output.
    fn stop(mut self, signal: &str) -> (Option<i32>, String) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).unwrap();
        (self.child.wait().unwrap().code(), rest)
    }
}

impl Drop for RunningViewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn routes_have_media_types_and_policies() {
    let v = RunningViewer::start();
    assert!(v.address.ip().is_loopback());
    for (target, kind) in [
        ("/", "text/html; charset=utf-8"),
        ("/?x=../../etc/passwd", "text/html; charset=utf-8"),
        ("/viewer.js", "text/javascript; charset=utf-8"),
        ("/viewer.css", "text/css; charset=utf-8"),
        ("/scene.bin", "application/octet-stream"),
        ("/progress.json", "application/json"),
    ] {
        let mut s = v.connect();
        s.write_all(
            format!("GET {target} HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", v.address.port()).as_bytes(),
        )
        .unwrap();
        let mut out = Vec::new();
        s.read_to_end(&mut out).unwrap();
        let end = out.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let head = text(&out[..end]);
        assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{target}: {head}");
        for header in [
            &format!("Content-Type: {kind}"),
            &format!("Content-Length: {}", out.len() - end - 4),
            "Cache-Control: no-store",
            "X-Content-Type-Options: nosniff",
            "Content-Security-Policy: default-src 'none'",
            "Cross-Origin-Resource-Policy: same-origin",
        ] {
            assert!(head.contains(header), "{target}: no {header} in\n{head}");
        }
    }
    let head = v.send(format!("HEAD /scene.bin HTTP/1.1\r\nHost: {}\r\n\r\n", v.address).as_bytes());
    assert!(
        head.starts_with("HTTP/1.1 200") && head.ends_with("\r\n\r\n") && !head.contains("Content-Length: 0")
    );
}

// Guards (pictures): the viewer listens on the loopback address only.
#[test]
fn server_listens_on_the_loopback_address_only() {
    let v = RunningViewer::start();
    // Linux lists every listening socket: state 0A, addresses as little-endian hexadecimal words.
    let Ok(table) = std::fs::read_to_string("/proc/net/tcp") else {
        println!("skipped: there is no /proc/net/tcp");
        return;
    };
    let port = format!(":{:04X}", v.address.port());
    let rows = table.lines().map(|l| l.split_whitespace().collect::<Vec<_>>());
    let listening: Vec<String> = rows
        .filter(|w| w.len() > 3 && w[3] == "0A" && w[1].ends_with(&port))
        .map(|w| w[1].to_string())
        .collect();
    assert_eq!(listening, [format!("0100007F{port}")]);
}

// Guards (pictures): the viewer serves a fixed list of routes.
#[test]
fn unknown_paths_and_foreign_hosts_are_refused() {
    let v = RunningViewer::start();
    for target in [
        "/../room.npz",
        "/..",
        "/room.npz",
        "/./",
        "//",
        "//viewer.js",
        "/viewer.js/",
        "/viewer.js/../viewer.js",
        "/%2e%2e/room.npz",
        "/%2e%2e%2froom.npz",
        "/..%2froom.npz",
        "/..%5croom.npz",
        "/..%c0%afroom.npz",
        "/%252e%252e/room.npz",
        "/..\\room.npz",
        "/viewer%2ejs",
        "/VIEWER.JS",
        "/etc/passwd",
        "/favicon.ico",
        "/;/viewer.js",
    ] {
        let answer = v.get(target);
        assert!(answer.starts_with("HTTP/1.1 404 "), "{target}: {answer}");
    }
    for target in ["", "..", "room.npz", "http://localhost/", "file:///etc/passwd", "*", "/a b"] {
        let answer = v.get(target);
        assert!(answer.starts_with("HTTP/1.1 400 "), "{target}: {answer}");
    }
    for host in
        ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:80", "[::1]", "0.0.0.0:80", ""]
    {
        let answer = v.send(format!("GET /scene.bin HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        assert!(answer.starts_with("HTTP/1.1 421 "), "{host}: {answer}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH"] {
        let answer = v.send(format!("{method} / HTTP/1.1\r\nHost: {}\r\n\r\n", v.address).as_bytes());
        assert!(answer.starts_with("HTTP/1.1 405 ") && answer.contains("Allow: GET, HEAD\r\n"), "{answer}");
    }
    let cross =
        format!("GET /scene.bin HTTP/1.1\r\nHost: {}\r\nSec-Fetch-Site: cross-site\r\n\r\n", v.address);
    assert!(v.send(cross.as_bytes()).starts_with("HTTP/1.1 403 "));
    v.assert_responsive();
}

/// A reproducible random number.
fn next_random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    *state >> 33
}

/// A malformed request, made from a valid one by one of ten kinds of damage.
fn damaged_request(kind: u64, state: &mut u64, address: SocketAddr) -> Vec<u8> {
    let valid = format!("GET / HTTP/1.1\r\nHost: {address}\r\nAccept: */*\r\n\r\n").into_bytes();
    let below = |state: &mut u64, n: usize| next_random(state) as usize % n;
    match kind {
        0 => (0..below(state, 600)).map(|_| next_random(state) as u8).collect(),
        1 => valid[..below(state, valid.len())].to_vec(),
        2 => {
            let mut b = valid;
            let i = below(state, 14);
            b[i] = b"\0\r\n\x7f\xff%"[below(state, 6)];
            b
        }
        3 => [b"GET / HTTP/1.1\r\n", vec![b'a'; 8192 + below(state, 40000)].as_slice(), b"\r\n\r\n"].concat(),
        4 => format!("GET / HTTP/1.1\r\n{}\r\n", "x: y\r\n".repeat(65 + below(state, 500))).into_bytes(),
        5 => format!("GET / HTTP/{}.{}\r\nHost: {address}\r\n\r\n", 2 + below(state, 9), below(state, 9))
            .into_bytes(),
        6 => {
            format!("GET / HTTP/1.1\r\nHost: {address}\r\nContent-Length: {}\r\n\r\n", 1 + next_random(state))
                .into_bytes()
        }
        7 => [valid, (0..1 + below(state, 300)).map(|_| next_random(state) as u8).collect()].concat(),
        8 => format!("GET / HTTP/1.1\nHost: {address}\n\n").into_bytes(),
        _ => {
            format!("GET /{} HTTP/1.1\r\nHost: {address}\r\n\r\n", "é\u{1f4a5}".repeat(1 + below(state, 20)))
                .into_bytes()
        }
    }
}

// Guards (pictures): the viewer survives malformed requests, slow clients and many clients.
#[test]
fn server_survives_a_thousand_malformed_requests() {
    let v = RunningViewer::start();
    let mut state = 20_240_229;
    for i in 0..1000 {
        let bytes = damaged_request(i % 10, &mut state, v.address);
        let answer = v.send(&bytes);
        let refused = answer.is_empty() || answer.starts_with("HTTP/1.1 4");
        assert!(refused, "{:?}\n{answer}", text(&bytes));
        if i % 100 == 99 {
            v.assert_responsive();
        }
    }
    v.assert_responsive();
    let (code, rest) = v.stop("-INT");
    assert_eq!(code, Some(0), "{rest}");
}

// Guards (pictures): the viewer survives malformed requests, slow clients and many clients.
#[test]
fn slow_and_many_clients_are_limited() {
    let v = RunningViewer::start();
    // A client that sends a byte now and then is disconnected, and so is one that sends nothing.
    let begin = Instant::now();
    let mut slow = v.connect();
    let silent = v.connect();
    let mut disconnected = false;
    for _ in 0..60 {
        std::thread::sleep(Duration::from_millis(250));
        if slow.write_all(b"G").is_err() {
            disconnected = true;
            break;
        }
    }
    assert!(disconnected && begin.elapsed() < Duration::from_secs(15));
    let mut out = Vec::new();
    let _ = { &silent }.read_to_end(&mut out);
    assert!(text(&out).starts_with("HTTP/1.1 408 "), "{}", text(&out));
    // Further connections get status 503, and are served when others end.
    let open: Vec<TcpStream> = (0..60).map(|_| v.connect()).collect();
    let busy = open.iter().skip(40).any(|mut s| {
        let mut out = Vec::new();
        let _ = s.read_to_end(&mut out);
        text(&out).starts_with("HTTP/1.1 503 ")
    });
    assert!(busy);
    drop(open);
    let end = Instant::now() + Duration::from_secs(10);
    while !v.get("/").starts_with("HTTP/1.1 200") {
        assert!(Instant::now() < end, "no connection became free");
    }
}

// Guards (pictures): Ctrl-C ends the viewer cleanly.
#[test]
fn interrupts_end_the_server_cleanly() {
    for signal in ["-INT", "-TERM"] {
        let v = RunningViewer::start();
        v.assert_responsive();
        // An open connection does not delay the end.
        let _idle = v.connect();
        let (code, rest) = v.stop(signal);
        assert_eq!(code, Some(0), "{signal}: {rest}");
        assert!(rest.ends_with("stopped\n"), "{signal}: {rest}");
    }
}

/// A small room whose walls reflect `reflectance`.
fn room(reflectance: f64) -> String {
    format!(
        "[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = {reflectance}\nfaces.z1 = {{ emission = 1 }}\n"
    )
}

impl RunningViewer {
    /// The progress once `is_reached` holds.
    fn progress_when(&self, is_reached: impl Fn(&serde_json::Value) -> bool) -> serde_json::Value {
        let end = Instant::now() + Duration::from_secs(120);
        loop {
            let answer = self.get("/progress.json");
            let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
            let progress: serde_json::Value = serde_json::from_str(body).unwrap();
            if is_reached(&progress) {
                return progress;
            }
            assert!(Instant::now() < end, "{progress}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn a_scene_is_shown_in_direct_light_then_as_draft_then_as_wanted_and_again_after_changes() {
    let mut v = RunningViewer::of("room.toml", room(0.5));
    // The page is there before its data.
    v.assert_responsive();
    let mut lines = Vec::new();
    let mut line = String::new();
    while lines.len() < 4 {
        line.clear();
        v.output.read_line(&mut line).unwrap();
        lines.push(line.trim().to_string());
    }
    assert!(
        ["Ctrl-C", "direct light:", "draft:", "normal:"]
            .iter()
            .zip(&lines)
            .all(|(x, line)| line.starts_with(x)),
        "{lines:?}"
    );
    let done = |version: u64| {
        move |p: &serde_json::Value| p["done"] == true && p["version"].as_u64() >= Some(version)
    };
    let p = v.progress_when(done(3));
    assert_eq!(
        (p["live"].as_bool(), p["version"].as_u64(), p["error"].is_null()),
        (Some(true), Some(3), true)
    );
    // A changed scene is solved again; one that is not valid leaves the data, and says why.
    v.folder.put("room.toml", room(0.8));
    v.progress_when(done(6));
    v.folder.put("room.toml", "[[surface]]\nboxx = 1");
    let p = v.progress_when(|p| !p["error"].is_null());
    assert_eq!(p["version"].as_u64(), Some(6));
    assert!(p["error"].as_str().unwrap().contains("room.toml:2:1"), "{p}");
    assert!(v.get("/scene.bin").starts_with("HTTP/1.1 200 OK"));
    v.folder.put("room.toml", room(0.2));
    v.progress_when(done(9));
    assert_eq!(v.stop("-INT").0, Some(0));
}

#[test]
fn many_zones_are_shown_in_sunlight_first() {
    let floor = r#"
solve.patch_size = 0.01
surface = [{ name = "floor", rectangle = { origin = [0, 0, 0], edge1 = [3, 0, 0], edge2 = [0, 3, 0] }, reflectance = 0.5 }]
light = [{ kind = "sun", direction = [0, 0.3, -1], irradiance = 1 }]
"#;
    let mut v = RunningViewer::of("floor.toml", floor);
    let mut lines = [String::new(), String::new()];
    lines.iter_mut().for_each(|line| drop(v.output.read_line(line)));
    assert!(lines[0].starts_with("Ctrl-C") && lines[1].starts_with("sunlight: 22500 zones"), "{lines:?}");
    assert_eq!(v.stop("-INT").0, Some(0));
}

#[test]
fn an_interrupt_ends_a_solve_in_progress() {
    let fine = room(0.5).replace("patch_size = 0.5", "patch_size = 0.02\ntolerance = 0.001");
    let v = RunningViewer::of("room.toml", fine);
    v.progress_when(|p| p["stage"].as_str().is_some_and(|s| !s.is_empty()));
    let begin = Instant::now();
    assert_eq!(v.stop("-INT").0, Some(0));
    assert!(begin.elapsed() < Duration::from_secs(60));
}

#[test]
fn a_model_is_shown_without_a_scene() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let v = RunningViewer::of("plate.obj", corners);
    v.progress_when(|p| p["version"].as_u64() >= Some(1));
    let f = Folder::new();
    f.put("a.obj", "v 0 0 0\n");
    refused(&f, Program, &["view", "a.obj"], "a.obj");
    refused(&f, Program, &["view", "none.toml"], "none.toml");
}

#[test]
fn port_in_use_is_reported() {
    let v = RunningViewer::start();
    let f = Folder::new();
    f.put("room.npz", solution());
    let port = v.address.port().to_string();
    refused(&f, Program, &["view", "room.npz", "--port", &port], "--port");
    refused(&f, Program, &["view", "none.npz"], "none.npz");
}

// Guards (pictures): the single-file page makes no request.
#[test]
fn single_file_page_loads_nothing() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["export", "room.npz", "-o", "out/page.html"]);
    let page = text(&f.get("out/page.html"));
    assert!(page.contains("<script id=\"data\"") && page.contains("default-src 'none'"));
    for external in [" src=", "<link rel=\"stylesheet\"", "http://", "https://", "@import"] {
        assert!(!page.contains(external), "{external}");
    }
    let before = f.listing();
    refused(&f, Program, &["export", "room.npz", "-o", "out/none/page.html"], "none");
    refused(&f, Program, &["export", "none.npz", "-o", "out/page.html"], "none.npz");
    assert_eq!(before, f.listing());
}
