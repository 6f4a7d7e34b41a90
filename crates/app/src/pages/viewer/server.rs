//! A small HTTP server for a browser on the same machine.
//!
//! It listens on 127.0.0.1, with one thread per connection and at most `MAX_CONNECTIONS`. A connection serves one request, which must arrive within
//! `REQUEST_TIMEOUT`, and is then closed. The targets are a fixed list of [`Route`]s; the content of some changes.

use super::request::{self, MAX_REQUEST_BYTES, Refusal, Request};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Largest number of simultaneous connections; others get status 503.
const MAX_CONNECTIONS: usize = 32;
/// Longest time for a request to arrive.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(4);
/// Longest time for an answer to be sent.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(120);

/// Headers of all answers: a browser may only show this page, and no other page may embed or read it.
const POLICY_HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
Cross-Origin-Opener-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n";

/// One answer of the server.
#[derive(Clone)]
pub struct Route {
    /// The target, spelled as in requests.
    pub target: &'static str,
    /// Media type.
    pub media_type: &'static str,
    /// Content.
    pub body: RouteBody,
}

/// The content of a route.
#[derive(Clone)]
pub enum RouteBody {
    /// The same in every answer.
    Fixed(Arc<[u8]>),
    /// The newest at the time of the request.
    Changing(Arc<dyn Fn() -> Arc<[u8]> + Send + Sync>),
}

impl RouteBody {
    fn bytes(&self) -> Arc<[u8]> {
        match self {
            RouteBody::Fixed(bytes) => bytes.clone(),
            RouteBody::Changing(newest) => newest(),
        }
    }
}

/// A listening server.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    routes: Arc<[Route]>,
    stop: Arc<AtomicBool>,
    connections: Arc<AtomicUsize>,
}

impl Server {
    /// Listens on the loopback address at `port`; 0 takes any free one.
    ///
    /// # Errors
    /// If the port is not available.
    pub fn bind(port: u16, routes: Vec<Route>) -> io::Result<Server> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        Ok(Server {
            listener,
            address,
            routes: routes.into(),
            stop: Arc::default(),
            connections: Arc::default(),
        })
    }

    /// Address and port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A function that makes [`Server::run`] return.
    pub fn stopper(&self) -> impl Fn() + Send + 'static {
        let (stop, address) = (self.stop.clone(), self.address);
        move || {
            stop.store(true, Ordering::SeqCst);
            // A connection wakes the loop.
            let _ = TcpStream::connect_timeout(&address, Duration::from_secs(1));
        }
    }

    /// Answers requests until stopped. Answers in progress end with the program.
    pub fn run(&self) {
        for stream in self.listener.incoming() {
            if self.stop.load(Ordering::SeqCst) {
                return;
            }
            match stream {
                Ok(stream) => self.accept(stream),
                // Probably no file descriptor is free; connections that end release some.
                Err(_) => std::thread::sleep(Duration::from_millis(20)),
            }
        }
    }

    fn accept(&self, mut stream: TcpStream) {
        let (connections, routes, port) =
            (self.connections.clone(), self.routes.clone(), self.address.port());
        let slot = ConnectionSlot::take(connections);
        if slot.is_none() {
            let _ = stream.set_write_timeout(Some(Duration::from_millis(50)));
            let _ = refuse(&mut stream, Refusal::Busy);
            return;
        }
        // If no thread can be started, the connection is dropped.
        let _ = std::thread::Builder::new().name("connection".into()).spawn(move || {
            let _slot = slot;
            let _ = serve(&mut stream, &routes, port);
        });
    }
}

/// One of the [`MAX_CONNECTIONS`], released when dropped.
struct ConnectionSlot(Arc<AtomicUsize>);

impl ConnectionSlot {
    fn take(connections: Arc<AtomicUsize>) -> Option<ConnectionSlot> {
        let increment = |n: usize| (n < MAX_CONNECTIONS).then_some(n + 1);
        connections.fetch_update(Ordering::SeqCst, Ordering::SeqCst, increment).ok()?;
        Some(ConnectionSlot(connections))
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn serve(stream: &mut TcpStream, routes: &[Route], port: u16) -> io::Result<()> {
    let request = receive(stream).and_then(|bytes| request::parse(&bytes, port));
    match request {
        Ok(r) => answer(stream, routes, &r)?,
        Err(why) => refuse(stream, why)?,
    }
    finish(stream)
}

/// Reads a request up to its empty line.
fn receive(stream: &mut TcpStream) -> Result<Vec<u8>, Refusal> {
    let (end, mut bytes, mut buffer) = (Instant::now() + REQUEST_TIMEOUT, Vec::new(), [0; 2048]);
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return Err(Refusal::Timeout);
        }
        match stream.read(&mut buffer) {
            Ok(0) => return Err(Refusal::Malformed),
            Ok(n) => bytes.extend_from_slice(&buffer[..n]),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return Err(Refusal::Timeout),
        }
        if let Some(at) = request::header_length(&bytes) {
            // A body is refused by its header; bytes without such a header are not part of a request.
            return if at == bytes.len() { Ok(bytes) } else { Err(Refusal::Malformed) };
        }
        if bytes.len() > MAX_REQUEST_BYTES {
            return Err(Refusal::TooLong);
        }
    }
}

fn answer(stream: &mut TcpStream, routes: &[Route], r: &Request) -> io::Result<()> {
    let (status, media_type, body) = match routes.iter().find(|x| x.target == r.target) {
        Some(route) => ("200 OK", route.media_type, route.body.bytes()),
        None => ("404 Not Found", "text/plain; charset=utf-8", Arc::from(&b"not found\n"[..])),
    };
    let sent = if r.head { None } else { Some(&body[..]) };
    send(stream, &AnswerHead { status, media_type, more: "", length: body.len() }, sent)
}

fn refuse(stream: &mut TcpStream, why: Refusal) -> io::Result<()> {
    let more = match why {
        Refusal::Method => "Allow: GET, HEAD\r\n",
        Refusal::Busy => "Retry-After: 1\r\n",
        _ => "",
    };
    let body = format!("{}\n", why.status_line());
    let media_type = "text/plain; charset=utf-8";
    let head = AnswerHead { status: why.status_line(), media_type, more, length: body.len() };
    send(stream, &head, Some(body.as_bytes()))
}

/// The head of an answer.
struct AnswerHead<'a> {
    status: &'a str,
    media_type: &'a str,
    /// Further header lines.
    more: &'a str,
    /// Length of the body, bytes.
    length: usize,
}

fn send(stream: &mut TcpStream, head: &AnswerHead, body: Option<&[u8]>) -> io::Result<()> {
    let end = Instant::now() + ANSWER_TIMEOUT;
    stream.set_write_timeout(Some(REQUEST_TIMEOUT))?;
    let AnswerHead { status, media_type, more, length } = head;
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {media_type}\r\nContent-Length: {length}\r\n{more}{POLICY_HEADERS}\r\n"
    );
    stream.write_all(head.as_bytes())?;
    for piece in body.unwrap_or(&[]).chunks(1 << 16) {
        if Instant::now() > end {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.write_all(piece)?;
    }
    stream.flush()
}

/// Closes the sending side, then reads some remaining bytes: closing a connection with unread bytes would discard the answer.
fn finish(stream: &mut TcpStream) -> io::Result<()> {
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(Duration::from_millis(200)))?;
    let mut buffer = [0; 4096];
    for _ in 0..64 {
        if matches!(stream.read(&mut buffer), Ok(0) | Err(_)) {
            break;
        }
    }
    Ok(())
}
