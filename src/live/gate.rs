//! The door before the server: a browser tells which web page opens a connection, and only the app's own pages come in.
//!
//! A WebSocket server on this machine can be reached by every page that is open in a browser here, wherever the page is from.
//! The server of the Foxglove SDK lets all of them in, so it listens on a loopback address and a port that nobody can guess,
//! and this door on the address that was asked for: it reads the head of the request, refuses it or passes everything on.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crate::limits::MOST_CLIENTS;

/// Pages that may watch: the Foxglove app in a browser, and its desktop version, which is a page from a file.
const APP_ORIGINS: [&str; 3] = ["https://app.foxglove.dev", "https://studio.foxglove.dev", "file://"];

/// The head of a request, and how long it may take to come.
const HEAD_BYTES: usize = 16 * 1024;
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two looks at whether somebody has come.
const SLICE: Duration = Duration::from_millis(10);

/// An open door; closed when it is dropped, and whoever is inside stays.
#[derive(Debug)]
pub struct Gate {
    closed: Arc<AtomicBool>,
}

impl Gate {
    /// Lets clients of `listener` through to `server`; pages of `origins` besides the app's own.
    pub fn open(listener: TcpListener, server: SocketAddr, origins: Vec<String>) -> io::Result<Gate> {
        listener.set_nonblocking(true)?;
        let closed = Arc::new(AtomicBool::new(false));
        let (told, inside) = (Arc::clone(&closed), Arc::new(AtomicUsize::new(0)));
        let origins: Arc<[String]> = origins.into();
        thread::spawn(move || {
            while !told.load(Ordering::Relaxed) {
                match listener.accept() {
                    Ok((client, _)) => {
                        let (origins, inside) = (Arc::clone(&origins), Arc::clone(&inside));
                        thread::spawn(move || {
                            let place = inside.fetch_add(1, Ordering::Relaxed);
                            // Who leaves in the middle of it has no more wishes.
                            let _ = admit(client, server, &origins, place < MOST_CLIENTS);
                            inside.fetch_sub(1, Ordering::Relaxed);
                        });
                    }
                    Err(_) => thread::sleep(SLICE),
                }
            }
        });
        Ok(Gate { closed })
    }
}

impl Drop for Gate {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

/// Serves one client until it or the server leaves.
fn admit(mut client: TcpStream, server: SocketAddr, origins: &[String], room: bool) -> io::Result<()> {
    client.set_nonblocking(false)?;
    client.set_read_timeout(Some(PATIENCE))?;
    let head = head(&mut client)?;
    let refusal = match origin(&head) {
        _ if !room => Some(("503 Service Unavailable", format!("there are {MOST_CLIENTS} clients already"))),
        Some(origin) if !is_welcome(&origin, origins) => {
            let way = "only the Foxglove app and pages of this machine may; --live-origin lets another in";
            Some(("403 Forbidden", format!("pages of this origin may not watch the run: {way}")))
        }
        _ => None,
    };
    if let Some((status, why)) = refusal {
        let length = why.len() + 1;
        let answer = format!(
            "HTTP/1.1 {status}\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{why}\n"
        );
        return client.write_all(answer.as_bytes());
    }
    let mut inner = TcpStream::connect(server)?;
    client.set_read_timeout(None)?;
    client.set_nodelay(true)?;
    inner.set_nodelay(true)?;
    inner.write_all(&head)?;
    let (mut from_client, mut to_server) = (client.try_clone()?, inner.try_clone()?);
    let up = thread::spawn(move || {
        let _ = io::copy(&mut from_client, &mut to_server);
        let _ = to_server.shutdown(Shutdown::Write);
    });
    let copied = io::copy(&mut inner, &mut client);
    let _ = client.shutdown(Shutdown::Both);
    let _ = inner.shutdown(Shutdown::Both);
    let _ = up.join();
    copied.map(drop)
}

/// Everything up to the empty line, and what has come with it.
fn head(client: &mut TcpStream) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    let mut bytes = [0; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let count = client.read(&mut bytes)?;
        if count == 0 || head.len() + count > HEAD_BYTES {
            return Err(io::ErrorKind::InvalidData.into());
        }
        head.extend_from_slice(&bytes[..count]);
    }
    Ok(head)
}

/// What a request says of the page that makes it; all of it where it is said more than once, which no page's is.
fn origin(head: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(head);
    let values = text.lines().skip(1).take_while(|line| !line.is_empty()).filter_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.trim().eq_ignore_ascii_case("origin").then(|| value.trim().to_string())
    });
    values.reduce(|all, value| format!("{all}, {value}"))
}

/// Whether pages of an origin may watch: the app, pages that this machine serves itself, and those that the user named.
fn is_welcome(origin: &str, origins: &[String]) -> bool {
    APP_ORIGINS.contains(&origin) || is_this_machine(origin) || origins.iter().any(|known| known == origin)
}

fn is_this_machine(origin: &str) -> bool {
    let Some((_, host)) = origin.split_once("://").filter(|(scheme, _)| matches!(*scheme, "http" | "https")) else {
        return false;
    };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    matches!(name, "localhost" | "127.0.0.1" | "[::1]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_app_and_this_machine_are_welcome_and_no_other_page() {
        for origin in [
            "https://app.foxglove.dev",
            "file://",
            "http://localhost",
            "http://localhost:8080",
            "https://127.0.0.1:3000",
            "http://[::1]:5173",
        ] {
            assert!(is_welcome(origin, &[]), "{origin}");
        }
        for origin in [
            "https://evil.example",
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.evil.example",
            "http://localhost.evil.example",
            "http://localhost:80.evil.example",
            "http://evil.example:127.0.0.1",
            "https://app.foxglove.dev, https://evil.example",
            "null",
            "",
        ] {
            assert!(!is_welcome(origin, &[]), "{origin}");
        }
        assert!(is_welcome("http://lab:8080", &["http://lab:8080".to_string()]));
    }

    #[test]
    fn the_origin_is_found_however_it_is_spelt() {
        let head = |lines: &str| format!("GET / HTTP/1.1\r\nHost: localhost\r\n{lines}\r\n\r\norigin: not a header");
        assert_eq!(origin(head("Upgrade: websocket").as_bytes()), None);
        for line in ["Origin: http://a", "origin:http://a", "ORIGIN :  http://a "] {
            assert_eq!(origin(head(line).as_bytes()), Some("http://a".to_string()), "{line}");
        }
        assert_eq!(origin(head("Origin: a\r\nOrigin: b").as_bytes()), Some("a, b".to_string()));
    }
}
