//! One HTTP request: its first line and its headers, from bytes.
//!
//! ```text
//!     METHOD SP /target SP HTTP/1.x CRLF  (name: value CRLF)*  CRLF
//! ```
//!
//! Only what a browser sends for a page of ours passes. A target is compared with the routes as it stands: nothing is decoded, joined or
//! looked up, so that no spelling of a path leads anywhere else. The Host must be ours, since a foreign name that resolves to this
//! machine (DNS rebinding) would otherwise read the scene from another site's page.

/// The most bytes of a request.
pub const MAX_BYTES: usize = 8192;
/// The most header lines.
const MAX_HEADERS: usize = 64;

/// A request that may be answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Where to, without what follows a question mark.
    pub target: String,
    /// True when only the headers are wanted.
    pub head: bool,
}

/// Why a request is not answered: an HTTP status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// 400: not a request, or one with a body.
    Malformed,
    /// 403: another site's page asks.
    Foreign,
    /// 405: neither GET nor HEAD.
    Method,
    /// 408: the request did not arrive in time.
    Late,
    /// 421: for another host.
    Host,
    /// 431: too long.
    Long,
    /// 503: too many at once.
    Busy,
}

impl Refusal {
    /// Status and reason.
    pub fn line(self) -> &'static str {
        match self {
            Refusal::Malformed => "400 Bad Request",
            Refusal::Foreign => "403 Forbidden",
            Refusal::Method => "405 Method Not Allowed",
            Refusal::Late => "408 Request Timeout",
            Refusal::Host => "421 Misdirected Request",
            Refusal::Long => "431 Request Header Fields Too Large",
            Refusal::Busy => "503 Service Unavailable",
        }
    }
}

/// Where the headers end, past the empty line, if they do.
pub fn end_of(bytes: &[u8]) -> Option<usize> {
    bytes.windows(4).position(|w| w == b"\r\n\r\n").map(|at| at + 4)
}

/// Reads a whole request for a server on `port`.
pub fn parse(bytes: &[u8], port: u16) -> Result<Request, Refusal> {
    if bytes.len() > MAX_BYTES {
        return Err(Refusal::Long);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| Refusal::Malformed)?;
    let text = text.strip_suffix("\r\n\r\n").ok_or(Refusal::Malformed)?;
    if text.bytes().any(|b| b < 32 && b != b'\r' && b != b'\n' && b != b'\t') {
        return Err(Refusal::Malformed);
    }
    let mut lines = text.split("\r\n");
    let (method, target) = first_line(lines.next().unwrap_or(""))?;
    let mut host = None;
    for (i, line) in lines.enumerate() {
        if i >= MAX_HEADERS {
            return Err(Refusal::Long);
        }
        let (name, value) = header(line)?;
        match name.as_str() {
            "host" if host.is_some() => return Err(Refusal::Malformed),
            "host" => host = Some(value),
            "content-length" if value != "0" => return Err(Refusal::Malformed),
            "transfer-encoding" => return Err(Refusal::Malformed),
            "sec-fetch-site" if !matches!(value, "same-origin" | "none") && target != "/" => {
                return Err(Refusal::Foreign);
            }
            _ => {}
        }
    }
    let ours =
        |h: &str| h == format!("127.0.0.1:{port}") || h.eq_ignore_ascii_case(&format!("localhost:{port}"));
    match host {
        None => Err(Refusal::Malformed),
        Some(h) if !ours(h) => Err(Refusal::Host),
        Some(_) => match method {
            "GET" | "HEAD" => Ok(Request { target: target.to_string(), head: method == "HEAD" }),
            _ => Err(Refusal::Method),
        },
    }
}

/// Method and target, the latter without its query.
fn first_line(line: &str) -> Result<(&str, &str), Refusal> {
    let words: Vec<&str> = line.split(' ').collect();
    let [method, target, "HTTP/1.1" | "HTTP/1.0"] = words[..] else {
        return Err(Refusal::Malformed);
    };
    let token = !method.is_empty() && method.len() < 20 && method.bytes().all(|b| b.is_ascii_uppercase());
    if !token || !target.starts_with('/') || !target.bytes().all(|b| b.is_ascii_graphic()) {
        return Err(Refusal::Malformed);
    }
    Ok((method, target.split('?').next().unwrap_or(target)))
}

/// Name in lower case and value.
fn header(line: &str) -> Result<(String, &str), Refusal> {
    let (name, value) = line.split_once(':').ok_or(Refusal::Malformed)?;
    let token = |b: u8| b.is_ascii_alphanumeric() || b"!#$%&'*+-.^_`|~".contains(&b);
    if name.is_empty() || !name.bytes().all(token) || value.contains(['\r', '\n']) {
        return Err(Refusal::Malformed);
    }
    Ok((name.to_ascii_lowercase(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(text: &str) -> Result<Request, Refusal> {
        parse(text.as_bytes(), 8765)
    }

    #[test]
    fn what_a_browser_sends_passes() {
        let r = ask(
            "GET /scene.bin?x=1 HTTP/1.1\r\nHost: 127.0.0.1:8765\r\nAccept: */*\r\nSec-Fetch-Site: same-origin\r\n\r\n",
        );
        assert_eq!(r, Ok(Request { target: "/scene.bin".into(), head: false }));
        let r = ask("HEAD / HTTP/1.0\r\nhost: LOCALHOST:8765\r\n\r\n");
        assert_eq!(r, Ok(Request { target: "/".into(), head: true }));
    }

    #[test]
    fn other_requests_are_refused_each_for_its_own_reason() {
        let host = "Host: localhost:8765\r\n";
        for (text, why) in [
            (String::new(), Refusal::Malformed),
            ("\r\n\r\n".into(), Refusal::Malformed),
            ("GET /\r\n\r\n".into(), Refusal::Malformed),
            ("GET / HTTP/1.1\r\n\r\n".into(), Refusal::Malformed),
            (format!("GET / HTTP/2\r\n{host}\r\n"), Refusal::Malformed),
            (format!("GET  / HTTP/1.1\r\n{host}\r\n"), Refusal::Malformed),
            (format!("GET http://localhost:8765/ HTTP/1.1\r\n{host}\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host}{host}\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host}Content-Length: 5\r\n\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host}no colon\r\n\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host} folded: x\r\n\r\n"), Refusal::Malformed),
            (format!("GET /\u{e9} HTTP/1.1\r\n{host}\r\n"), Refusal::Malformed),
            (format!("GET / HTTP/1.1\r\n{host}x: \0\r\n\r\n"), Refusal::Malformed),
            (format!("POST / HTTP/1.1\r\n{host}\r\n"), Refusal::Method),
            (format!("OPTIONS / HTTP/1.1\r\n{host}\r\n"), Refusal::Method),
            ("GET / HTTP/1.1\r\nHost: evil.example:8765\r\n\r\n".into(), Refusal::Host),
            ("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".into(), Refusal::Host),
            (
                format!("GET /scene.bin HTTP/1.1\r\n{host}Sec-Fetch-Site: cross-site\r\n\r\n"),
                Refusal::Foreign,
            ),
            (format!("GET / HTTP/1.1\r\n{host}{}\r\n", "a: b\r\n".repeat(65)), Refusal::Long),
            (format!("GET /{} HTTP/1.1\r\n{host}\r\n", "a".repeat(9000)), Refusal::Long),
        ] {
            assert_eq!(ask(&text), Err(why), "{text:?}");
        }
    }
}
