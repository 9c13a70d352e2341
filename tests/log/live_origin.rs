//! Web pages do not read along: the server of `--live` looks at the origin of who opens a connection.

#![cfg(feature = "live")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use phalanx::live::Server;

/// The first line of the answer to a request to watch, and what follows the head.
fn answer(server: &Server, more: &str) -> (String, Vec<u8>) {
    let address = server.url().trim_start_matches("ws://").to_string();
    let mut stream = TcpStream::connect(&address).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(5))).expect("set");
    let request = format!(
        "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: \
         dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n{more}\r\n"
    );
    stream.write_all(request.as_bytes()).expect("sent");
    let (mut bytes, mut part) = (Vec::new(), [0; 4096]);
    // The server introduces itself at once to whom it lets in.
    while !String::from_utf8_lossy(&bytes).contains("serverInfo") {
        match stream.read(&mut part) {
            Ok(0) | Err(_) => break,
            Ok(count) => bytes.extend_from_slice(&part[..count]),
        }
    }
    let text = String::from_utf8_lossy(&bytes).into_owned();
    (text.lines().next().unwrap_or_default().to_string(), bytes)
}

#[test]
fn programs_and_the_app_are_let_in_and_other_pages_are_not() {
    let server = Server::start("127.0.0.1:0", "a run", &["http://lab:8080".to_string()]).expect("a free port");
    for origin in
        ["", "Origin: https://app.foxglove.dev\r\n", "Origin: http://localhost:8080\r\n", "Origin: http://lab:8080\r\n"]
    {
        let (status, bytes) = answer(&server, origin);
        assert!(status.starts_with("HTTP/1.1 101"), "{origin}: {status}");
        assert!(String::from_utf8_lossy(&bytes).contains("a run"), "{origin}");
    }
    for origin in ["https://evil.example", "null", "http://localhost.evil.example"] {
        let (status, bytes) = answer(&server, &format!("Origin: {origin}\r\n"));
        let text = String::from_utf8_lossy(&bytes);
        assert!(status.starts_with("HTTP/1.1 403") && text.contains("--live-origin"), "{origin}: {text}");
        assert!(!text.contains("serverInfo") && !text.contains("a run"), "{origin}: {text}");
    }
    // What speaks no HTTP, or too much of it, is not waited for longer than that takes.
    let (status, _) = answer(&server, &format!("X: {}\r\n", "x".repeat(20_000)));
    assert_eq!(status, "");
    assert!(answer(&server, "").0.starts_with("HTTP/1.1 101"), "others are still served");
    server.finish();
}

#[test]
fn an_address_in_use_is_said_with_another() {
    let server = Server::start("127.0.0.1:0", "a run", &[]).expect("a free port");
    let address = server.url().trim_start_matches("ws://").to_string();
    let error = Server::start(&address, "another", &[]).err().expect("it is taken").to_string();
    assert!(error.contains("another program listens there") && error.contains("--live 127.0.0.1:"), "{error}");
}
