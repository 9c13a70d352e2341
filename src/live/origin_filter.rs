//! Origin check in front of the server: only allowed web pages can connect.
//!
//! Every page open in a local browser can reach a WebSocket server on this machine, and the server of the Foxglove SDK
//! accepts all of them. It therefore listens on an unguessable loopback address and port. This filter listens on the
//! requested address, reads the head of each request, and rejects the request or forwards the connection.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crate::limits::MAX_CLIENTS;

/// Allowed origins: the Foxglove app in a browser and its desktop version, which is a page from a file.
const APP_ORIGINS: [&str; 3] = ["https://app.foxglove.dev", "https://studio.foxglove.dev", "file://"];

/// Maximum size of the head of a request, bytes.
const HEAD_BYTES: usize = 16 * 1024;
/// Timeout for receiving the head of a request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval between checks for new connections.
const ACCEPT_INTERVAL: Duration = Duration::from_millis(10);

/// A listening filter. Dropping it stops listening; open connections remain.
#[derive(Debug)]
pub struct OriginFilter {
    closed: Arc<AtomicBool>,
}

impl OriginFilter {
    /// Forwards clients of `listener` to `server`; pages of `extra_origins` are allowed in addition to the default
    /// ones.
    pub fn open(listener: TcpListener, server: SocketAddr, extra_origins: Vec<String>) -> io::Result<OriginFilter> {
        listener.set_nonblocking(true)?;
        let closed = Arc::new(AtomicBool::new(false));
        let (stop_flag, client_count) = (Arc::clone(&closed), Arc::new(AtomicUsize::new(0)));
        let extra_origins: Arc<[String]> = extra_origins.into();
        thread::spawn(move || {
            while !stop_flag.load(Ordering::Relaxed) {
                match listener.accept() {
                    Ok((client, _)) => {
                        let (extra_origins, client_count) = (Arc::clone(&extra_origins), Arc::clone(&client_count));
                        thread::spawn(move || {
                            let previous_clients = client_count.fetch_add(1, Ordering::Relaxed);
                            // An error only means that the client or the server has disconnected.
                            let _ = serve_client(client, server, &extra_origins, previous_clients < MAX_CLIENTS);
                            client_count.fetch_sub(1, Ordering::Relaxed);
                        });
                    }
                    Err(_) => thread::sleep(ACCEPT_INTERVAL),
                }
            }
        });
        Ok(OriginFilter { closed })
    }
}

impl Drop for OriginFilter {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

/// Serves one client until it or the server disconnects.
fn serve_client(
    mut client: TcpStream,
    server: SocketAddr,
    extra_origins: &[String],
    has_capacity: bool,
) -> io::Result<()> {
    client.set_nonblocking(false)?;
    client.set_read_timeout(Some(HEAD_TIMEOUT))?;
    let head = read_head(&mut client)?;
    let rejection = match origin_header(&head) {
        _ if !has_capacity => Some(("503 Service Unavailable", format!("{MAX_CLIENTS} clients are already connected"))),
        Some(origin) if !is_allowed(&origin, extra_origins) => {
            let remedy =
                "only the Foxglove app and pages of this machine are allowed; --live-origin allows another origin";
            Some(("403 Forbidden", format!("pages of this origin may not watch the run: {remedy}")))
        }
        _ => None,
    };
    if let Some((status, reason)) = rejection {
        let length = reason.len() + 1;
        let response = format!(
            "HTTP/1.1 {status}\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{reason}\n"
        );
        return client.write_all(response.as_bytes());
    }
    let mut upstream = TcpStream::connect(server)?;
    client.set_read_timeout(None)?;
    client.set_nodelay(true)?;
    upstream.set_nodelay(true)?;
    upstream.write_all(&head)?;
    let (mut from_client, mut to_server) = (client.try_clone()?, upstream.try_clone()?);
    let upload = thread::spawn(move || {
        let _ = io::copy(&mut from_client, &mut to_server);
        let _ = to_server.shutdown(Shutdown::Write);
    });
    let copied = io::copy(&mut upstream, &mut client);
    let _ = client.shutdown(Shutdown::Both);
    let _ = upstream.shutdown(Shutdown::Both);
    let _ = upload.join();
    copied.map(drop)
}

/// Reads up to the empty line after the head, including any bytes received after it.
fn read_head(client: &mut TcpStream) -> io::Result<Vec<u8>> {
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

/// Returns the header `Origin` of a request. Repeated headers are joined, which matches no allowed origin.
fn origin_header(head: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(head);
    let values = text.lines().skip(1).take_while(|line| !line.is_empty()).filter_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.trim().eq_ignore_ascii_case("origin").then(|| value.trim().to_string())
    });
    values.reduce(|all, value| format!("{all}, {value}"))
}

/// Whether pages of an origin may watch: the app, pages of this machine, and those given by the user.
fn is_allowed(origin: &str, extra_origins: &[String]) -> bool {
    APP_ORIGINS.contains(&origin) || is_local(origin) || extra_origins.iter().any(|known| known == origin)
}

fn is_local(origin: &str) -> bool {
    let Some((_, host)) = origin.split_once("://").filter(|(scheme, _)| matches!(*scheme, "http" | "https")) else {
        return false;
    };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    matches!(name, "localhost" | "127.0.0.1" | "[::1]")
}
