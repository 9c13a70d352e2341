//! The server of `--live` checks the origin of connections and rejects other web pages.

#![cfg(feature = "live")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use phalanx::live::Server;

/// Requests a connection; returns the status line of the response and all received bytes.
fn send_request(server: &Server, extra_headers: &str) -> (String, Vec<u8>) {
    let address = server.url().trim_start_matches("ws://").to_string();
    let mut stream = TcpStream::connect(&address).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(5))).expect("set");
    let head = format!(
        "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: \
         dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n{extra_headers}\r\n"
    );
    stream.write_all(head.as_bytes()).expect("sent");
    let (mut bytes, mut buffer) = (Vec::new(), [0; 4096]);
    // The server sends `serverInfo` to accepted clients.
    while !String::from_utf8_lossy(&bytes).contains("serverInfo") {
        match stream.read(&mut buffer) {
            Ok(0) | Err(_) => break,
            Ok(count) => bytes.extend_from_slice(&buffer[..count]),
        }
    }
    let text = String::from_utf8_lossy(&bytes).into_owned();
    (text.lines().next().unwrap_or_default().to_string(), bytes)
}

#[test]
fn accepts_programs_and_the_app_and_rejects_other_pages() {
    let server = Server::start("127.0.0.1:0", "a run", &["http://lab:8080".to_string()]).expect("a free port");
    for header in [
        "",
        "Origin: https://app.foxglove.dev\r\n",
        "Origin: file://\r\n",
        "origin:http://localhost\r\n",
        "Origin: http://localhost:8080\r\n",
        "Origin: https://127.0.0.1:3000\r\n",
        "Origin: http://[::1]:5173\r\n",
        "Origin: http://lab:8080\r\n",
    ] {
        let (status, bytes) = send_request(&server, header);
        assert!(status.starts_with("HTTP/1.1 101"), "{header}: {status}");
        assert!(String::from_utf8_lossy(&bytes).contains("a run"), "{header}");
    }
    for origin in [
        "Origin: https://evil.example",
        "ORIGIN :  https://evil.example ",
        "Origin: http://app.foxglove.dev",
        "Origin: https://app.foxglove.dev.evil.example",
        "Origin: http://localhost.evil.example",
        "Origin: http://localhost:80.evil.example",
        "Origin: http://evil.example:127.0.0.1",
        // Repeated headers are joined.
        "Origin: http://localhost\r\nOrigin: http://localhost",
        "Origin: null",
        "Origin:",
    ] {
        let (status, bytes) = send_request(&server, &format!("{origin}\r\n"));
        let text = String::from_utf8_lossy(&bytes);
        assert!(status.starts_with("HTTP/1.1 403") && text.contains("--live-origin"), "{origin}: {text}");
        assert!(!text.contains("serverInfo") && !text.contains("a run"), "{origin}: {text}");
    }
    // A request with too large a head is dropped without a response.
    let (status, _) = send_request(&server, &format!("X: {}\r\n", "x".repeat(20_000)));
    assert_eq!(status, "");
    assert!(send_request(&server, "").0.starts_with("HTTP/1.1 101"), "others are still served");
    server.finish();
}

#[test]
fn error_for_a_used_address_suggests_another() {
    let server = Server::start("127.0.0.1:0", "a run", &[]).expect("a free port");
    let address = server.url().trim_start_matches("ws://").to_string();
    let error = Server::start(&address, "another", &[]).err().expect("the address is in use").to_string();
    assert!(error.contains("another program listens there") && error.contains("--live 127.0.0.1:"), "{error}");
}
