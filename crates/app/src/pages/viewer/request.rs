//! Parsing of an HTTP request: first line and headers.
//!
//! ```text
//!     METHOD SP /target SP HTTP/1.x CRLF  (name: value CRLF)*  CRLF
//! ```
//!
//! Only requests of a browser for the page of this server are accepted. A target is compared with the routes literally: it is not decoded or joined with a
//! path, so that no spelling reaches a file. The Host must be this server, since a foreign name that resolves to this machine (DNS rebinding) would let the
//! page of another site read the scene.

/// Largest request, bytes.
pub const MAX_REQUEST_BYTES: usize = 8192;
/// Largest number of header lines.
const MAX_HEADERS: usize = 64;

/// A valid request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// Target without the query.
    pub target: String,
    /// True for the method HEAD, which omits the body.
    pub head: bool,
}

/// The reason to refuse a request, as an HTTP status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// 400: not a request, or a request with a body.
    Malformed,
    /// 403: a request from the page of another site.
    CrossSite,
    /// 405: a method other than GET and HEAD.
    Method,
    /// 408: the request did not arrive in time.
    Timeout,
    /// 421: a request for another host.
    WrongHost,
    /// 431: the request is too long.
    TooLong,
    /// 503: too many connections.
    Busy,
}

impl Refusal {
    /// Status line: code and reason.
    #[must_use]
    pub fn status_line(self) -> &'static str {
        match self {
            Refusal::Malformed => "400 Bad Request",
            Refusal::CrossSite => "403 Forbidden",
            Refusal::Method => "405 Method Not Allowed",
            Refusal::Timeout => "408 Request Timeout",
            Refusal::WrongHost => "421 Misdirected Request",
            Refusal::TooLong => "431 Request Header Fields Too Large",
            Refusal::Busy => "503 Service Unavailable",
        }
    }
}

/// Length of the headers with their empty line; none if they are incomplete.
#[must_use]
pub fn header_length(bytes: &[u8]) -> Option<usize> {
    bytes.windows(4).position(|w| w == b"\r\n\r\n").map(|at| at + 4)
}

/// Parses a whole request to a server on `port`.
///
/// # Errors
/// The reason to refuse it.
pub fn parse(bytes: &[u8], port: u16) -> Result<Request, Refusal> {
    if bytes.len() > MAX_REQUEST_BYTES {
        return Err(Refusal::TooLong);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| Refusal::Malformed)?;
    let text = text.strip_suffix("\r\n\r\n").ok_or(Refusal::Malformed)?;
    if text.bytes().any(|b| b < 32 && b != b'\r' && b != b'\n' && b != b'\t') {
        return Err(Refusal::Malformed);
    }
    let mut lines = text.split("\r\n");
    let (method, target) = parse_first_line(lines.next().unwrap_or(""))?;
    let mut host = None;
    for (i, line) in lines.enumerate() {
        if i >= MAX_HEADERS {
            return Err(Refusal::TooLong);
        }
        let (name, value) = parse_header(line)?;
        match name.as_str() {
            "host" if host.is_some() => return Err(Refusal::Malformed),
            "host" => host = Some(value),
            "content-length" if value != "0" => return Err(Refusal::Malformed),
            "transfer-encoding" => return Err(Refusal::Malformed),
            "sec-fetch-site" if !matches!(value, "same-origin" | "none") && target != "/" => {
                return Err(Refusal::CrossSite);
            }
            _ => {}
        }
    }
    let is_this_server =
        |h: &str| h == format!("127.0.0.1:{port}") || h.eq_ignore_ascii_case(&format!("localhost:{port}"));
    match host {
        None => Err(Refusal::Malformed),
        Some(h) if !is_this_server(h) => Err(Refusal::WrongHost),
        Some(_) => match method {
            "GET" | "HEAD" => Ok(Request { target: target.to_string(), head: method == "HEAD" }),
            _ => Err(Refusal::Method),
        },
    }
}

/// Method and target, the latter without its query.
fn parse_first_line(line: &str) -> Result<(&str, &str), Refusal> {
    let words: Vec<&str> = line.split(' ').collect();
    let [method, target, "HTTP/1.1" | "HTTP/1.0"] = words[..] else {
        return Err(Refusal::Malformed);
    };
    let is_token = !method.is_empty() && method.len() < 20 && method.bytes().all(|b| b.is_ascii_uppercase());
    if !is_token || !target.starts_with('/') || !target.bytes().all(|b| b.is_ascii_graphic()) {
        return Err(Refusal::Malformed);
    }
    Ok((method, target.split('?').next().unwrap_or(target)))
}

/// Name in lower case and value.
fn parse_header(line: &str) -> Result<(String, &str), Refusal> {
    let (name, value) = line.split_once(':').ok_or(Refusal::Malformed)?;
    let is_token = |b: u8| b.is_ascii_alphanumeric() || b"!#$%&'*+-.^_`|~".contains(&b);
    if name.is_empty() || !name.bytes().all(is_token) || value.contains(['\r', '\n']) {
        return Err(Refusal::Malformed);
    }
    Ok((name.to_ascii_lowercase(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<Request, Refusal> {
        parse(text.as_bytes(), 8765)
    }

    #[test]
    fn browser_requests_are_accepted() {
        let r = parse_text(
            "GET /scene.bin?x=1 HTTP/1.1\r\nHost: 127.0.0.1:8765\r\nAccept: */*\r\nSec-Fetch-Site: same-origin\r\n\r\n",
        );
        assert_eq!(r, Ok(Request { target: "/scene.bin".into(), head: false }));
        let r = parse_text("HEAD / HTTP/1.0\r\nhost: LOCALHOST:8765\r\n\r\n");
        assert_eq!(r, Ok(Request { target: "/".into(), head: true }));
    }

    #[test]
    fn invalid_requests_are_refused_with_their_reason() {
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
            ("GET / HTTP/1.1\r\nHost: evil.example:8765\r\n\r\n".into(), Refusal::WrongHost),
            ("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".into(), Refusal::WrongHost),
            (
                format!("GET /scene.bin HTTP/1.1\r\n{host}Sec-Fetch-Site: cross-site\r\n\r\n"),
                Refusal::CrossSite,
            ),
            (format!("GET / HTTP/1.1\r\n{host}{}\r\n", "a: b\r\n".repeat(65)), Refusal::TooLong),
            (format!("GET /{} HTTP/1.1\r\n{host}\r\n", "a".repeat(9000)), Refusal::TooLong),
        ] {
            assert_eq!(parse_text(&text), Err(why), "{text:?}");
        }
    }
}
