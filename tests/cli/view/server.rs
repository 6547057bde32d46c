//! `bumper view --serve`, asked by those who mean well and by others.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::Child;

use super::*;

struct Server {
    process: Child,
    address: SocketAddr,
    _place: Place,
}

impl Server {
    /// As the README has it, but at any port, and of a small run.
    fn start() -> Self {
        let command = "bumper view results --serve 127.0.0.1:8080";
        let (place, results) = Place::with_results();
        let words = command.split(' ').skip(1).map(|word| match word {
            "results" => &results,
            "127.0.0.1:8080" => "127.0.0.1:0",
            other => other,
        });
        let mut command = place.bumper(&words.collect::<Vec<_>>());
        let mut process = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
        let address = address.unwrap_or_else(|| panic!("{line}")).parse().unwrap();
        Self { process, address, _place: place }
    }

    fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address).unwrap()
    }

    /// What comes back, until the connection is closed.
    fn answer(&self, request: &[u8]) -> String {
        let mut stream = self.connect();
        // It may be cut off before all of it is sent.
        let _ = stream.write_all(request);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8(answer).unwrap()
    }

    fn ask(&self, line: &str) -> String {
        self.answer(format!("{line}\r\nHost: {}\r\n\r\n", self.address).as_bytes())
    }

    fn interrupt(mut self) {
        // SAFETY: a plain system call; the process is our own child, which is not reaped yet.
        unsafe { libc::kill(self.process.id() as libc::pid_t, libc::SIGINT) };
        assert_eq!(self.process.wait().unwrap().code(), Some(0));
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn status(answer: &str) -> &str {
    answer.split("\r\n").next().unwrap_or_default().strip_prefix("HTTP/1.1 ").unwrap_or("none")
}

#[test]
fn the_page_is_served_with_headers_that_keep_it_alone() {
    let server = Server::start();
    let answer = server.ask("GET / HTTP/1.1");
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert_eq!(status(head), "200 OK");
    assert!(body.starts_with("<!doctype html>") && body.ends_with("</html>\n"));
    for header in [
        &format!("Content-Length: {}", body.len()),
        "Content-Type: text/html; charset=utf-8",
        "X-Content-Type-Options: nosniff",
        "Content-Security-Policy: default-src 'none'",
        "frame-ancestors 'none'",
    ] {
        assert!(head.contains(header), "{header} is missing in {head}");
    }
    let without_body = server.ask("HEAD / HTTP/1.1");
    assert_eq!(without_body, format!("{head}\r\n\r\n"));
    server.interrupt();
}

#[test]
fn everything_else_is_refused() {
    let server = Server::start();
    for path in ["/x", "/../etc/passwd", "/?a=b", "/favicon.ico"] {
        assert_eq!(status(&server.ask(&format!("GET {path} HTTP/1.1"))), "404 Not Found", "{path}");
    }
    let answer = server.ask("POST / HTTP/1.1");
    assert_eq!(status(&answer), "405 Method Not Allowed");
    assert!(answer.contains("Allow: GET, HEAD"));
    let elsewhere = server.answer(b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    assert_eq!(status(&elsewhere), "421 Misdirected Request");
    for request in
        [&b"\r\n\r\n"[..], b"GET /\r\n\r\n", b"\xff\xfe\0\r\n\r\n", b"GET / SPDY/9\r\n\r\n"]
    {
        assert_eq!(status(&server.answer(request)), "400 Bad Request", "{request:?}");
    }
    let endless = [b"GET / HTTP/1.1\r\nX: ".to_vec(), vec![b'a'; 1 << 20]].concat();
    let answer = server.answer(&endless);
    assert!(["431 Request Header Fields Too Large", "none"].contains(&status(&answer)), "{answer}");
    assert_eq!(status(&server.ask("GET / HTTP/1.1")), "200 OK", "and goes on");
    server.interrupt();
}

#[test]
fn who_says_nothing_or_takes_nothing_keeps_nobody_waiting() {
    let server = Server::start();
    let silent: Vec<TcpStream> = (0..20).map(|_| server.connect()).collect();
    let mut deaf = server.connect();
    deaf.write_all(format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", server.address).as_bytes())
        .unwrap();
    assert_eq!(status(&server.ask("GET / HTTP/1.1")), "200 OK");
    // They are cut off, however long they stay.
    for mut stream in silent {
        let mut nothing = Vec::new();
        let _ = stream.read_to_end(&mut nothing);
        assert_eq!(nothing, b"");
    }
    let others: Vec<TcpStream> = (0..200).map(|_| server.connect()).collect();
    drop(others);
    let mut last = String::new();
    for _ in 0..200 {
        last = server.ask("GET / HTTP/1.1");
        if status(&last) == "200 OK" {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(status(&last), "200 OK", "when they have gone");
    server.interrupt();
}

#[test]
fn a_port_that_is_taken_is_an_error_before_anything_is_computed() {
    let server = Server::start();
    let (place, address) = (Place::new(), server.address.to_string());
    let output = place.view(&["--serve", &address]);
    refused(&output, 1, &["cannot serve here", &address]);
    server.interrupt();
}
