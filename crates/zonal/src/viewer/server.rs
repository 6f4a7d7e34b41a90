//! A small HTTP server for one reader on the same machine.
//!
//! Bound to 127.0.0.1. A thread a connection, at most [`MAX_CONNECTIONS`]; one request each, which must arrive within
//! [`PATIENCE`]; then the answer and the end. What may be asked for is a list of [`Route`]s made beforehand.

use super::request::{self, MAX_BYTES, Refusal, Request};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Connections at once; others are told to come again.
pub const MAX_CONNECTIONS: usize = 32;
/// How long a request may take to arrive.
pub const PATIENCE: Duration = Duration::from_secs(4);
/// How long a reader may take for the whole answer.
const SENDING: Duration = Duration::from_secs(120);

/// What browsers may do with our answers: nothing but show this page, and no other page may embed or read them.
const POLICY: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
Cross-Origin-Opener-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n";

/// Something that may be asked for.
#[derive(Clone, Debug)]
pub struct Route {
    /// The target, exactly as requests must spell it.
    pub target: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// The bytes.
    pub body: Arc<[u8]>,
}

/// A server that listens.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    routes: Arc<[Route]>,
    stop: Arc<AtomicBool>,
    open: Arc<AtomicUsize>,
}

impl Server {
    /// Listens on the loopback address at `port`; 0 takes any free one.
    pub fn bind(port: u16, routes: Vec<Route>) -> io::Result<Server> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        Ok(Server { listener, address, routes: routes.into(), stop: Arc::default(), open: Arc::default() })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A call that makes [`Server::run`] return.
    pub fn stopper(&self) -> impl Fn() + Send + 'static {
        let (stop, address) = (self.stop.clone(), self.address);
        move || {
            stop.store(true, Ordering::SeqCst);
            // Wakes the loop, which waits for a connection.
            let _ = TcpStream::connect_timeout(&address, Duration::from_secs(1));
        }
    }

    /// Answers until stopped. Answers under way are left to end with the program.
    pub fn run(&self) {
        for stream in self.listener.incoming() {
            if self.stop.load(Ordering::SeqCst) {
                return;
            }
            match stream {
                Ok(stream) => self.take(stream),
                // Out of descriptors, most likely: they come back as connections end.
                Err(_) => std::thread::sleep(Duration::from_millis(20)),
            }
        }
    }

    fn take(&self, mut stream: TcpStream) {
        let (open, routes, port) = (self.open.clone(), self.routes.clone(), self.address.port());
        let place = Place::take(open);
        if place.is_none() {
            let _ = stream.set_write_timeout(Some(Duration::from_millis(50)));
            let _ = refuse(&mut stream, Refusal::Busy);
            return;
        }
        // Where no thread is to be had the connection is dropped.
        let _ = std::thread::Builder::new().name("connection".into()).spawn(move || {
            let _place = place;
            let _ = serve(&mut stream, &routes, port);
        });
    }
}

/// One of the connections allowed at once, given back when dropped.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(open: Arc<AtomicUsize>) -> Option<Place> {
        let free = |n: usize| (n < MAX_CONNECTIONS).then_some(n + 1);
        open.fetch_update(Ordering::SeqCst, Ordering::SeqCst, free).ok()?;
        Some(Place(open))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn serve(stream: &mut TcpStream, routes: &[Route], port: u16) -> io::Result<()> {
    let asked = receive(stream).and_then(|bytes| request::parse(&bytes, port));
    match asked {
        Ok(r) => answer(stream, routes, &r)?,
        Err(why) => refuse(stream, why)?,
    }
    finish(stream)
}

/// The request up to its empty line.
fn receive(stream: &mut TcpStream) -> Result<Vec<u8>, Refusal> {
    let (end, mut bytes, mut buffer) = (Instant::now() + PATIENCE, Vec::new(), [0; 2048]);
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return Err(Refusal::Late);
        }
        match stream.read(&mut buffer) {
            Ok(0) => return Err(Refusal::Malformed),
            Ok(n) => bytes.extend_from_slice(&buffer[..n]),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return Err(Refusal::Late),
        }
        if let Some(at) = request::end_of(&bytes) {
            // A body would be refused by its header; what follows without one is no request of ours.
            return if at == bytes.len() { Ok(bytes) } else { Err(Refusal::Malformed) };
        }
        if bytes.len() > MAX_BYTES {
            return Err(Refusal::Long);
        }
    }
}

fn answer(stream: &mut TcpStream, routes: &[Route], r: &Request) -> io::Result<()> {
    let (status, kind, body): (_, _, &[u8]) = match routes.iter().find(|x| x.target == r.target) {
        Some(route) => ("200 OK", route.kind, &route.body),
        None => ("404 Not Found", "text/plain; charset=utf-8", b"there is nothing here\n"),
    };
    send(stream, status, kind, "", if r.head { None } else { Some(body) }, body.len())
}

fn refuse(stream: &mut TcpStream, why: Refusal) -> io::Result<()> {
    let more = match why {
        Refusal::Method => "Allow: GET, HEAD\r\n",
        Refusal::Busy => "Retry-After: 1\r\n",
        _ => "",
    };
    let body = format!("{}\n", why.line());
    send(stream, why.line(), "text/plain; charset=utf-8", more, Some(body.as_bytes()), body.len())
}

fn send(
    stream: &mut TcpStream,
    status: &str,
    kind: &str,
    more: &str,
    body: Option<&[u8]>,
    length: usize,
) -> io::Result<()> {
    let end = Instant::now() + SENDING;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{more}{POLICY}\r\n"
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

/// Says that nothing more comes, and reads a little of what is still on its way: closed upon unread bytes, a connection would take the
/// answer back.
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
