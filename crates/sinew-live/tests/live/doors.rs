//! The server under connections that ask for nothing and requests that name two hosts.

use sinew_lab::arm::plan_tour;
use sinew_live::{Kinematic, Server, ServerSettings};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;

fn server() -> Server {
    let machine = sinew_lab::machine_file::load_machine(Path::new("bench_joint"), None).unwrap().machine;
    let trajectory = plan_tour(&machine, Some(14.0), |_| Ok(None)).unwrap();
    let limits = vec![[1.0, 100.0]; machine.muscles.len()];
    let shown = ("tour".to_owned(), String::new());
    let source = Box::new(Kinematic::new(machine, trajectory, shown, limits).unwrap());
    Server::start(ServerSettings { address: "127.0.0.1:0".parse().unwrap(), source, foxglove: None }).unwrap()
}

/// The status that answers a request with these lines in its head.
fn status(address: SocketAddr, head: &str) -> u16 {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET / HTTP/1.1\r\n{head}Connection: close\r\n\r\n").unwrap();
    let mut text = Vec::new();
    stream.read_to_end(&mut text).unwrap();
    String::from_utf8_lossy(&text).split(' ').nth(1).unwrap().parse().unwrap()
}

/// A connection that begins a request, or not even that.
fn half_open(address: SocketAddr, number: usize) -> TcpStream {
    let mut stream = TcpStream::connect(address).unwrap();
    let begun = ["", "GET", "GET / HTTP/1.1\r\nHost: ", "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nA: b\r\n"];
    // Where it has already given way.
    let _ = stream.write_all(begun[number % begun.len()].as_bytes());
    stream
}

/// Whether the server has closed a connection, after at most so long.
fn is_closed(stream: &mut TcpStream, patience: Duration) -> bool {
    stream.set_read_timeout(Some(patience)).unwrap();
    let mut rest = Vec::new();
    match stream.read_to_end(&mut rest) {
        Ok(_) => true,
        Err(error) => !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
    }
}

#[test]
fn half_open_connections_keep_no_page_out_while_they_last() {
    let server = server();
    let address = server.address();
    let mut held: Vec<TcpStream> = Vec::new();
    for number in 0..700 {
        held.push(half_open(address, number));
        if number % 100 == 99 {
            assert_eq!(status(address, &format!("Host: {address}\r\n")), 200, "after {number}");
        }
    }
    let begun = Instant::now();
    let stream = TcpStream::connect(address).unwrap();
    let mut request = format!("ws://{address}/stream").into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
    let (mut page, _) = tungstenite::client::client(request, stream).unwrap();
    assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
    // More of them do not end a page that is open.
    held.extend((0..150).map(|number| half_open(address, number)));
    for _ in 0..20 {
        assert!(page.read().unwrap().len() > 16);
    }
    let mut open = 0;
    for stream in &mut held {
        open += usize::from(!is_closed(stream, Duration::from_millis(1)));
    }
    assert!(open <= 64, "{open} connections of one address are open");
}

#[test]
fn a_connection_without_a_whole_header_is_closed_after_seconds_also_between_two_requests() {
    let server = server();
    let address = server.address();
    let begun = Instant::now();
    let mut silent: Vec<TcpStream> = (0..4).map(|number| half_open(address, number)).collect();
    let mut answered = half_open(address, 0);
    write!(answered, "GET /nothing HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    for stream in silent.iter_mut().chain([&mut answered]) {
        assert!(is_closed(stream, Duration::from_secs(20)));
    }
    let closed = begun.elapsed();
    assert!(closed > Duration::from_secs(3) && closed < Duration::from_secs(15), "{closed:?}");
}

#[test]
fn a_request_that_names_two_hosts_or_two_origins_is_refused() {
    let server = server();
    let address = server.address();
    let (own, origin) = (format!("Host: {address}\r\n"), format!("Origin: http://{address}\r\n"));
    for (head, expected) in [
        (own.clone(), 200),
        (format!("{own}{origin}"), 200),
        (format!("{own}{own}"), 400),
        (format!("{own}Host: evil.example\r\n"), 400),
        (format!("Host: evil.example\r\n{own}"), 400),
        (format!("{own}host: evil.example\r\n"), 400),
        (format!("{own}{origin}Origin: http://evil.example\r\n"), 400),
        (String::new(), 400),
    ] {
        assert_eq!(status(address, &head), expected, "{head}");
    }
}
