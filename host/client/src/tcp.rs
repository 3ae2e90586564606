//! Rigs behind a TCP address: `massline virtual --tcp` on any system, or a serial port that another computer shares.

use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

use crate::error::ClientError;
use crate::transport::Transport;
use massline_result::Error;

/// Time to find a host and connect to it, with all its addresses.
const CONNECT: Duration = Duration::from_secs(5);
/// The same for one attempt to connect again, after which a person is told that the rig is gone.
const RECONNECT: Duration = Duration::from_secs(1);
/// How long the other side may take to accept a frame.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// A server that is busy accepts a connection and closes it within this time, plus the way there and back.
const REFUSED_WITHIN: Duration = Duration::from_millis(250);

/// Host and port, written `tcp://HOST:PORT` or `tcp:HOST:PORT`; an IPv6 address is in brackets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TcpAddress {
    host: String,
    port: u16,
}

impl TcpAddress {
    /// Parses the name of a port; `None` when it is not one of TCP.
    ///
    /// # Errors
    /// `bad_address` when it begins with `tcp:` but names no host and port.
    pub fn parse(name: &str) -> Option<Result<Self, Error>> {
        let rest = name.strip_prefix("tcp:")?;
        let address = rest.strip_prefix("//").unwrap_or(rest);
        let address = address.strip_suffix('/').unwrap_or(address);
        Some(Self::host_and_port(address).ok_or_else(|| {
            Error::input(
                "bad_address",
                format!(
                    "{name} is not a TCP address: write tcp://HOST:PORT, such as tcp://127.0.0.1:4000"
                ),
            )
        }))
    }

    fn host_and_port(address: &str) -> Option<Self> {
        let (host, port) = address.rsplit_once(':')?;
        let port = port.parse().ok().filter(|&port| port != 0)?;
        let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        let valid = match bare {
            Some(ip) => ip.parse::<std::net::Ipv6Addr>().is_ok(),
            None => !host.is_empty() && !host.contains(['/', ':', '[', ']', ' ']),
        };
        valid.then(|| Self { host: bare.unwrap_or(host).to_owned(), port })
    }

    /// The socket addresses of the host. A name server that does not answer is waited for until `deadline`.
    fn resolve(&self, deadline: Instant) -> io::Result<Vec<SocketAddr>> {
        let (sender, receiver) = channel();
        let target = (self.host.clone(), self.port);
        // The system cannot be told how long to look a name up: the thread ends when it has.
        thread::Builder::new().name("resolve".into()).spawn(move || {
            let addresses = target.to_socket_addrs().map(Iterator::collect);
            // Nobody waits any more after the deadline.
            let _ = sender.send(addresses);
        })?;
        let late = |_| io::Error::new(ErrorKind::TimedOut, "the host's name is not found in time");
        receiver.recv_timeout(deadline.saturating_duration_since(Instant::now())).map_err(late)?
    }

    fn connect(&self, within: Duration) -> io::Result<TcpStream> {
        let deadline = Instant::now() + within;
        let mut failure = io::Error::new(ErrorKind::NotFound, "the host has no address");
        for address in self.resolve(deadline)? {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            match TcpStream::connect_timeout(&address, left) {
                Ok(stream) => {
                    // Requests are small and each waits for its answer.
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                    return Ok(stream);
                }
                Err(e) => failure = e,
            }
        }
        Err(failure)
    }
}

impl fmt::Display for TcpAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { host, port } = self;
        if host.contains(':') {
            write!(f, "tcp://[{host}]:{port}")
        } else {
            write!(f, "tcp://{host}:{port}")
        }
    }
}

/// A rig behind a TCP address.
#[derive(Debug)]
pub struct TcpTransport {
    address: TcpAddress,
    name: String,
    stream: Option<TcpStream>,
    /// False until something has been read from this connection. A server that has another client closes a
    /// connection without a byte.
    answered: bool,
}

impl TcpTransport {
    /// Connects.
    ///
    /// # Errors
    /// [`ClientError::Unreachable`] within a few seconds.
    pub fn open(address: TcpAddress) -> Result<Self, ClientError> {
        let name = address.to_string();
        match address.connect(CONNECT) {
            Ok(stream) => Ok(Self { address, name, stream: Some(stream), answered: false }),
            Err(e) => Err(ClientError::Unreachable { port: name, reason: e.to_string() }),
        }
    }

    fn lost(&mut self, error: io::Error) -> io::Error {
        self.stream = None;
        error
    }
}

impl Transport for TcpTransport {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let stream = self.stream.as_mut().ok_or_else(closed)?;
        // A timeout of zero means none at all.
        let patience = timeout.max(Duration::from_millis(1));
        match stream.set_read_timeout(Some(patience)).and_then(|()| stream.read(buffer)) {
            Ok(0) => Err(self.lost(closed())),
            Ok(n) => {
                self.answered = true;
                Ok(n)
            }
            Err(e) if waits(&e) => Ok(0),
            Err(e) => Err(self.lost(e)),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let stream = self.stream.as_mut().ok_or_else(closed)?;
        // How much of the bytes is on its way when the time is up is not known: the connection is of no more use.
        stream.write_all(bytes).map_err(|e| self.lost(e))
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.stream = None;
        let started = Instant::now();
        let stream = self.address.connect(RECONNECT)?;
        if !self.answered {
            let there_and_back = started.elapsed();
            stream.set_read_timeout(Some(REFUSED_WITHIN + 2 * there_and_back))?;
            match stream.peek(&mut [0]) {
                Ok(0) => return Err(busy()),
                Err(e) if !waits(&e) => return Err(busy()),
                _ => {}
            }
        }
        self.answered = false;
        self.stream = Some(stream);
        Ok(())
    }

    fn name(&self) -> &str {
        &self.name
    }
}

fn waits(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn closed() -> io::Error {
    io::Error::new(ErrorKind::NotConnected, "the other side has closed the connection")
}

fn busy() -> io::Error {
    io::Error::new(
        ErrorKind::ResourceBusy,
        "it closes the connection without an answer; if no other program is connected, no massline rig listens there",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    fn address(listener: &TcpListener) -> TcpAddress {
        let name = format!("tcp://{}", listener.local_addr().unwrap());
        TcpAddress::parse(&name).unwrap().unwrap()
    }

    #[test]
    fn both_ways_of_writing_an_address_are_the_same() {
        for name in ["tcp://rig.local:4000", "tcp:rig.local:4000", "tcp://rig.local:4000/"] {
            let address = TcpAddress::parse(name).unwrap().unwrap();
            assert_eq!(address.to_string(), "tcp://rig.local:4000", "{name}");
        }
        let six = TcpAddress::parse("tcp:[::1]:4000").unwrap().unwrap();
        assert_eq!((six.host.as_str(), six.to_string().as_str()), ("::1", "tcp://[::1]:4000"));
    }

    #[test]
    fn an_address_without_host_or_port_is_refused() {
        for name in [
            "tcp:",
            "tcp://",
            "tcp://host",
            "tcp://:4000",
            "tcp://host:",
            "tcp://host:0",
            "tcp://host:70000",
            "tcp://::1:4000",
            "tcp://[::1:4000",
            "tcp://a/b:4000",
        ] {
            let error = TcpAddress::parse(name).unwrap().unwrap_err();
            assert_eq!((error.code(), error.exit_code()), ("bad_address", 2), "{name}");
        }
    }

    #[test]
    fn serial_ports_are_no_tcp_addresses() {
        for name in ["COM3", r"\\.\COM12", "/dev/ttyACM0", "/dev/tcp:1"] {
            assert!(TcpAddress::parse(name).is_none(), "{name}");
        }
    }

    #[test]
    fn bytes_cross_and_silence_is_no_error() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut transport = TcpTransport::open(address(&listener)).unwrap();
        let (mut other, _) = listener.accept().unwrap();
        transport.write_all(&[0, 3, 255]).unwrap();
        let mut got = [0; 3];
        other.read_exact(&mut got).unwrap();
        assert_eq!(got, [0, 3, 255]);
        assert_eq!(transport.read(&mut got, Duration::ZERO).unwrap(), 0);
    }

    #[test]
    fn a_closed_connection_is_lost_until_it_is_reopened() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut transport = TcpTransport::open(address(&listener)).unwrap();
        let (mut other, _) = listener.accept().unwrap();
        other.write_all(b"x").unwrap();
        drop(other);
        let mut buffer = [0; 8];
        assert_eq!(transport.read(&mut buffer, CONNECT).unwrap(), 1);
        for _ in 0..2 {
            let lost = transport.read(&mut buffer, CONNECT).unwrap_err();
            assert_eq!(lost.kind(), ErrorKind::NotConnected);
        }
        transport.reconnect().unwrap();
        let (mut other, _) = listener.accept().unwrap();
        other.write_all(b"y").unwrap();
        assert_eq!(transport.read(&mut buffer, CONNECT).unwrap(), 1);
    }

    #[test]
    fn a_server_that_closes_every_connection_unanswered_is_busy() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut transport = TcpTransport::open(address(&listener)).unwrap();
        drop(listener.accept().unwrap());
        assert!(transport.read(&mut [0], CONNECT).is_err());
        let server = thread::spawn(move || drop(listener.accept().unwrap()));
        assert_eq!(transport.reconnect().unwrap_err().kind(), ErrorKind::ResourceBusy);
        server.join().unwrap();
    }

    #[test]
    fn a_port_where_nobody_listens_is_unreachable() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = address(&listener);
        drop(listener);
        assert_eq!(TcpTransport::open(address).unwrap_err().code(), "unreachable");
    }
}
