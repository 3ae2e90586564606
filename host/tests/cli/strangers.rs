//! A port at which something else than a rig is.

use std::fs::File;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::thread;

use nix::pty::openpty;
use nix::unistd::ttyname;

use crate::program::answer;

/// Code and message of the error when the device at this port is asked for its identity.
fn identify(port: &str) -> (String, String) {
    let (exit, answer) = answer(&["device", "identify", "--port", port]);
    assert_eq!(exit, 4, "{answer}");
    let text = |key: &str| answer["error"][key].as_str().unwrap().to_owned();
    (text("code"), text("message"))
}

/// A terminal, whose other end gives this answer to what it reads. The end of the program is kept open, because reading
/// fails while nobody has it.
fn terminal(answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static) -> (String, OwnedFd) {
    let pair = openpty(None, None).unwrap();
    let mut master = File::from(pair.master);
    let name = ttyname(&pair.slave).unwrap().display().to_string();
    thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(count) = master.read(&mut bytes) {
            if master.write_all(&answer(&bytes[..count])).is_err() {
                break;
            }
        }
    });
    (name, pair.slave)
}

/// A server that treats each connection like this.
fn server(serve: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp://{}", listener.local_addr().unwrap());
    thread::spawn(move || listener.incoming().flatten().for_each(&serve));
    port
}

/// Waits for a request.
fn request(stream: &mut TcpStream) {
    let _ = stream.read(&mut [0; 1000]);
}

#[test]
fn a_device_that_talks_is_named_with_its_first_bytes() {
    for (line, shown) in [
        ("$GPGGA,123519,4807.038,N,01131.000,E,1,08\r\n", "\"$GPGGA,123519,4807.038,N,01131.0…\""),
        ("> \r\n>>> ", "\"> \\r\\n>>> "),
        ("ERROR\r\n", "\"ERROR\\r\\n"),
        ("\x1b[2Jboot:", "\"\\x1b[2Jboot:"),
    ] {
        let (port, _end) = terminal(move |_| line.as_bytes().to_vec());
        let (code, message) = identify(&port);
        assert_eq!(code, "not_a_rig", "{line}: {message}");
        let start = format!("{port} answers, but not as a massline rig: {shown}");
        assert!(message.starts_with(&start), "{line}: {message}");
    }
}

#[test]
fn a_loopback_plug_is_named_as_an_echo() {
    let (port, _end) = terminal(<[u8]>::to_vec);
    let (code, message) = identify(&port);
    assert_eq!(code, "echo", "{message}");
    assert!(message.contains("returns what is sent to it: this is an echo"), "{message}");
}

#[test]
fn a_silent_port_does_not_answer() {
    let (port, _end) = terminal(|_| Vec::new());
    let (code, message) = identify(&port);
    assert_eq!(code, "no_answer", "{message}");
}

#[test]
fn a_server_of_something_else_is_named_with_its_first_bytes() {
    let http = server(|mut stream| {
        request(&mut stream);
        let _ = stream.write_all(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n");
    });
    let ssh = server(|mut stream| {
        let _ = stream.write_all(b"SSH-2.0-OpenSSH_9.2p1\r\n");
        request(&mut stream);
    });
    let binary = server(|mut stream| {
        request(&mut stream);
        let _ = stream.write_all(&[0xFF; 64]);
    });
    for (port, shown) in
        [(http, "\"HTTP/1.1 400"), (ssh, "\"SSH-2.0-OpenSSH_9.2p1\\r\\n"), (binary, "\"\\xff\\xff")]
    {
        let (code, message) = identify(&port);
        assert_eq!(code, "not_a_rig", "{message}");
        assert!(message.contains(&format!("not as a massline rig: {shown}")), "{message}");
    }
}

#[test]
fn a_server_that_closes_each_connection_is_named_as_that() {
    let (code, message) = identify(&server(|mut stream| request(&mut stream)));
    assert_eq!(code, "connection_closed", "{message}");
    assert!(message.contains("closes the connection when it is asked"), "{message}");
    // Without reading the request, as the server of a rig that has another client does.
    let (code, message) = identify(&server(drop));
    assert_eq!(code, "port_busy", "{message}");
    let text = "it closes the connection without an answer; if no other program is connected, no massline rig listens \
         there";
    assert!(message.contains(text), "{message}");
}
