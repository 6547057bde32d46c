//! One page over HTTP/1.1 (RFC 9112), to this machine only.
//!
//! Who asks is not trusted: a request has to be whole soon and short, and one that is not is cut off
//! without harm to others.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Of a request with its headers.
const MOST_BYTES: usize = 16 << 10;
/// For a request to be whole, and for each part of the answer to be taken.
const PATIENCE: Duration = Duration::from_secs(5);
/// For the whole answer to be taken.
const LONGEST_ANSWER: Duration = Duration::from_secs(60);
/// Connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// How soon Ctrl-C is noticed.
const TICK: Duration = Duration::from_millis(50);
/// Bytes of an answer between two looks at the clock.
const PIECE: usize = 64 << 10;

/// An address that only this machine can reach, and a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Loopback(SocketAddr);

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum NotLoopback {
    #[error("{0} is no address with a port: write 127.0.0.1:8080")]
    NotAnAddress(String),
    #[error(
        "others could reach {0}, and pages are served to this machine only: write 127.0.0.1:{port}",
        port = .0.port()
    )]
    Reachable(SocketAddr),
}

impl FromStr for Loopback {
    type Err = NotLoopback;

    fn from_str(text: &str) -> Result<Self, NotLoopback> {
        let address: SocketAddr =
            text.parse().map_err(|_| NotLoopback::NotAnAddress(text.to_owned()))?;
        if address.ip().is_loopback() {
            Ok(Self(address))
        } else {
            Err(NotLoopback::Reachable(address))
        }
    }
}

impl fmt::Display for Loopback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A page's place, taken before the page is there.
pub(super) struct PageServer {
    listener: TcpListener,
    address: SocketAddr,
}

impl PageServer {
    pub(super) fn bind(at: Loopback) -> io::Result<Self> {
        let listener = TcpListener::bind(at.0)?;
        let address = listener.local_addr()?;
        Ok(Self { listener, address })
    }

    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Until it is interrupted; then what is being answered is cut off.
    pub(super) fn serve(
        self,
        page: Vec<u8>,
        policy: &str,
        interrupt: &AtomicBool,
    ) -> io::Result<()> {
        let site = Arc::new(Site { page, policy: policy.to_owned(), address: self.address });
        let open = Arc::new(AtomicUsize::new(0));
        self.listener.set_nonblocking(true)?;
        while !interrupt.load(Ordering::Relaxed) {
            match self.listener.accept() {
                Ok((stream, _)) => converse(stream, &site, &open),
                // Nobody, or somebody who has gone again.
                Err(_) => thread::sleep(TICK),
            }
        }
        Ok(())
    }
}

/// In a thread of its own, if there are not too many.
fn converse(stream: TcpStream, site: &Arc<Site>, open: &Arc<AtomicUsize>) {
    let (site, open) = (Arc::clone(site), Arc::clone(open));
    if open.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
        open.fetch_sub(1, Ordering::Relaxed);
        return;
    }
    thread::spawn(move || {
        // Whoever it was has gone, or is cut off.
        let _ = site.answer(stream);
        open.fetch_sub(1, Ordering::Relaxed);
    });
}

struct Site {
    page: Vec<u8>,
    policy: String,
    address: SocketAddr,
}

impl Site {
    fn answer(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = read_request(&mut stream)?;
        let (status, has_body) = match self.judge(&request) {
            Ok(has_body) => (OK, has_body),
            Err(status) => (status, false),
        };
        let deadline = Instant::now() + LONGEST_ANSWER;
        stream.write_all(self.head(status).as_bytes())?;
        for piece in self.page.chunks(PIECE).take_while(|_| has_body) {
            if Instant::now() > deadline {
                return Err(io::ErrorKind::TimedOut.into());
            }
            stream.write_all(piece)?;
        }
        hang_up(&stream)
    }

    /// Whether the page itself is to be sent.
    fn judge(&self, request: &Request) -> Result<bool, Status> {
        let Request::Whole(bytes) = request else { return Err(TOO_LARGE) };
        let text = std::str::from_utf8(bytes).map_err(|_| BAD_REQUEST)?;
        let mut lines = text.split("\r\n");
        let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let [method, target, version] = words[..] else { return Err(BAD_REQUEST) };
        if !["HTTP/1.0", "HTTP/1.1"].contains(&version) || !target.starts_with('/') {
            return Err(BAD_REQUEST);
        }
        let mut hosts = Vec::new();
        for line in lines.take_while(|line| !line.is_empty()) {
            let (name, value) = line.split_once(':').ok_or(BAD_REQUEST)?;
            if name.is_empty() || !name.bytes().all(is_of_a_token) {
                return Err(BAD_REQUEST);
            }
            if name.eq_ignore_ascii_case("host") {
                hosts.push(value.trim());
            }
        }
        // A name that somebody has pointed to this machine gets nothing.
        if !matches!(hosts[..], [host] if self.is_us(host)) {
            return Err(WRONG_HOST);
        }
        let is_get = match method {
            "GET" => true,
            "HEAD" => false,
            _ => return Err(WRONG_METHOD),
        };
        if target == "/" { Ok(is_get) } else { Err(NOT_FOUND) }
    }

    fn is_us(&self, host: &str) -> bool {
        let port = self.address.port();
        host == self.address.to_string() || host.eq_ignore_ascii_case(&format!("localhost:{port}"))
    }

    fn head(&self, status: Status) -> String {
        let length = if status == OK { self.page.len() } else { 0 };
        let allow = if status == WRONG_METHOD { "Allow: GET, HEAD\r\n" } else { "" };
        let policy = &self.policy;
        format!(
            "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {length}\r\n{allow}\
             Content-Security-Policy: {policy}; frame-ancestors 'none'\r\nX-Content-Type-Options: nosniff\r\n\
             Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
        )
    }
}

type Status = &'static str;

const OK: Status = "200 OK";
const BAD_REQUEST: Status = "400 Bad Request";
const NOT_FOUND: Status = "404 Not Found";
const WRONG_METHOD: Status = "405 Method Not Allowed";
const WRONG_HOST: Status = "421 Misdirected Request";
const TOO_LARGE: Status = "431 Request Header Fields Too Large";

enum Request {
    /// Up to the empty line after its headers.
    Whole(Vec<u8>),
    TooLarge,
}

fn read_request(stream: &mut TcpStream) -> io::Result<Request> {
    let deadline = Instant::now() + PATIENCE;
    let (mut bytes, mut piece) = (Vec::new(), [0; 2048]);
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        let read = stream.read(&mut piece)?;
        if read == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        bytes.extend_from_slice(&piece[..read]);
        if let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") {
            bytes.truncate(end + 4);
            return Ok(Request::Whole(bytes));
        }
        if bytes.len() > MOST_BYTES {
            return Ok(Request::TooLarge);
        }
    }
}

/// What the other side still sends is taken for a moment: with bytes unread, closing would take the
/// answer away from it.
fn hang_up(stream: &TcpStream) -> io::Result<()> {
    stream.shutdown(std::net::Shutdown::Write)?;
    let deadline = Instant::now() + Duration::from_secs(1);
    let (mut rest, mut piece) = (stream, [0; 2048]);
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(());
        }
        stream.set_read_timeout(Some(left))?;
        if rest.read(&mut piece)? == 0 {
            return Ok(());
        }
    }
}

/// RFC 9110, section 5.6.2.
fn is_of_a_token(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"!#$%&'*+-.^_`|~".contains(&byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(request: &str) -> Result<bool, Status> {
        let site = Site {
            page: b"page".to_vec(),
            policy: String::new(),
            address: "127.0.0.1:80".parse().unwrap(),
        };
        site.judge(&Request::Whole(request.as_bytes().to_vec()))
    }

    #[test]
    fn only_the_page_can_be_asked_for() {
        let from = |line: &str| judged(&format!("{line}\r\nHost: 127.0.0.1:80\r\n\r\n"));
        assert_eq!(from("GET / HTTP/1.1"), Ok(true));
        assert_eq!(from("HEAD / HTTP/1.0"), Ok(false));
        for path in ["/index.html", "/..", "/?x", "//", "/%2e%2e/etc/passwd"] {
            assert_eq!(from(&format!("GET {path} HTTP/1.1")), Err(NOT_FOUND), "{path}");
        }
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "get"] {
            assert_eq!(from(&format!("{method} / HTTP/1.1")), Err(WRONG_METHOD), "{method}");
        }
        for line in
            ["", "GET /", "GET / HTTP/2", "GET  / HTTP/1.1", "GET / HTTP/1.1 x", "GET * HTTP/1.1"]
        {
            assert_eq!(from(line), Err(BAD_REQUEST), "{line}");
        }
    }

    #[test]
    fn a_request_names_this_machine_as_its_host() {
        let with = |headers: &str| judged(&format!("GET / HTTP/1.1\r\n{headers}\r\n"));
        for host in
            ["Host: 127.0.0.1:80\r\n", "hOST:localhost:80\r\n", "A: b\r\nHost: LOCALHOST:80\r\n"]
        {
            assert_eq!(with(host), Ok(true), "{host}");
        }
        let twice = "Host: localhost:80\r\nHost: localhost:80\r\n";
        for host in ["", "Host: evil.example\r\n", "Host: 127.0.0.1:81\r\n", "Host:\r\n", twice] {
            assert_eq!(with(host), Err(WRONG_HOST), "{host}");
        }
        for header in ["no colon\r\n", ": x\r\n", "Ho st: x\r\n"] {
            assert_eq!(with(header), Err(BAD_REQUEST), "{header}");
        }
    }

    #[test]
    fn only_addresses_of_this_machine_are_served() {
        for address in ["127.0.0.1:0", "127.1.2.3:8080", "[::1]:80"] {
            assert!(address.parse::<Loopback>().is_ok(), "{address}");
        }
        let refused = |text: &str| text.parse::<Loopback>().unwrap_err().to_string();
        for address in ["0.0.0.0:80", "[::]:80", "192.168.1.1:80", "10.0.0.1:80", "[fe80::1]:80"] {
            assert!(refused(address).contains("this machine only"), "{address}");
        }
        for address in ["", "localhost:80", "127.0.0.1", "127.0.0.1:70000", "8080"] {
            assert!(refused(address).contains("no address with a port"), "{address}");
        }
    }
}
