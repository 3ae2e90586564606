//! Serves a virtual rig at a TCP address, on systems without pseudo-terminals and over a network.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::pipe::HostEnd;

/// How soon the end of the server, and a new client, are noticed.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// A client that has accepted nothing for this long is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a new client waits for the present one to leave, which may have closed its connection just before.
const LEAVES_WITHIN: Duration = Duration::from_millis(100);

/// A listening socket that carries the link of a rig until it is dropped, for one client at a time.
///
/// While a client is connected, the connection of another one is closed without a byte. While none is, the
/// rig's link is unplugged: the next client does not receive what the rig sends in the meantime, and the rig
/// continues as without a host.
#[derive(Debug)]
pub struct TcpServer {
    address: SocketAddr,
    ended: Arc<AtomicBool>,
    doorman: Option<JoinHandle<()>>,
}

impl TcpServer {
    /// Listens at `address`, on a free port when its port is 0, and carries the bytes of `link`.
    ///
    /// # Errors
    /// When the address is not one of this computer or its port is in use, and when no thread is left.
    pub fn serve(link: HostEnd, address: impl ToSocketAddrs) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        link.unplug();
        let ended = Arc::new(AtomicBool::new(false));
        let flag = ended.clone();
        let doorman = thread::Builder::new()
            .name("tcp server".into())
            .spawn(move || admit_clients(&listener, &link, &flag))?;
        Ok(Self { address, ended, doorman: Some(doorman) })
    }

    /// The address at which it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for TcpServer {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        if let Some(doorman) = self.doorman.take() {
            // A panic of the thread has already been printed.
            let _ = doorman.join();
        }
    }
}

/// Admits one client after the other until the server ends.
fn admit_clients(listener: &TcpListener, link: &HostEnd, ended: &AtomicBool) {
    let mut client: Option<Client> = None;
    while !ended.load(Ordering::Acquire) {
        if client.as_ref().is_some_and(Client::has_left) {
            client = None;
        }
        let Ok((stream, _)) = listener.accept() else {
            // Nobody, or a client that has left before it was admitted.
            thread::sleep(LOOK_EVERY);
            continue;
        };
        if client.as_ref().is_none_or(Client::leaves) {
            drop(client.take());
            // A client that cannot be served is disconnected here and may try again.
            client = Client::admit(stream, link).ok();
        }
    }
}

/// A connected client and the threads that carry its bytes.
struct Client {
    stream: TcpStream,
    link: HostEnd,
    gone: Arc<AtomicBool>,
    pumps: Vec<JoinHandle<()>>,
}

impl Client {
    fn admit(stream: TcpStream, link: &HostEnd) -> io::Result<Self> {
        // Some systems hand the listener's setting on.
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(LOOK_EVERY))?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        let (reading, writing) = (stream.try_clone()?, stream.try_clone()?);
        let gone = Arc::new(AtomicBool::new(false));
        let mut client = Self { stream, link: link.clone(), gone: gone.clone(), pumps: Vec::new() };
        link.plug();
        let (to_rig, flag) = (link.clone(), gone.clone());
        client.spawn("tcp to rig", move || carry_to_rig(reading, to_rig, &flag))?;
        let to_client = link.clone();
        client.spawn("rig to tcp", move || carry_to_client(writing, to_client, &gone))?;
        Ok(client)
    }

    fn spawn(&mut self, name: &str, pump: impl FnOnce() + Send + 'static) -> io::Result<()> {
        self.pumps.push(thread::Builder::new().name(name.into()).spawn(pump)?);
        Ok(())
    }

    fn has_left(&self) -> bool {
        self.gone.load(Ordering::Acquire)
    }

    /// True when it has left or leaves at once.
    fn leaves(&self) -> bool {
        let deadline = Instant::now() + LEAVES_WITHIN;
        while !self.has_left() && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(1));
        }
        self.has_left()
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.gone.store(true, Ordering::Release);
        // This fails when the client has closed its end, too.
        let _ = self.stream.shutdown(Shutdown::Both);
        self.link.unplug();
        for pump in self.pumps.drain(..) {
            // A panic of the pump has already been printed.
            let _ = pump.join();
        }
    }
}

/// Carries the client's bytes to the rig, at the speed at which the rig reads, until the client leaves.
fn carry_to_rig(mut stream: TcpStream, mut link: HostEnd, gone: &AtomicBool) {
    link.set_timeout(LOOK_EVERY);
    let mut buffer = [0; 4096];
    while !gone.load(Ordering::Acquire) {
        match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => write_all(&mut link, &buffer[..count], gone),
            Err(error) if waits(&error) => {}
            Err(_) => break,
        }
    }
    gone.store(true, Ordering::Release);
}

fn write_all(link: &mut HostEnd, mut bytes: &[u8], gone: &AtomicBool) {
    while !bytes.is_empty() && !gone.load(Ordering::Acquire) {
        match link.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(error) if waits(&error) => {}
            Err(_) => gone.store(true, Ordering::Release),
        }
    }
}

/// Carries the rig's bytes to the client until it leaves or accepts nothing, or the rig ends.
fn carry_to_client(mut stream: TcpStream, mut link: HostEnd, gone: &AtomicBool) {
    link.set_timeout(LOOK_EVERY);
    let mut buffer = [0; 4096];
    while !gone.load(Ordering::Acquire) {
        match link.read(&mut buffer) {
            Ok(count) if stream.write_all(&buffer[..count]).is_ok() => {}
            Err(error) if waits(&error) => {}
            _ => break,
        }
    }
    gone.store(true, Ordering::Release);
}

fn waits(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::echo::{END, many_bytes, rig};
    use crate::pipe::pipe;

    /// Never reached unless something hangs.
    const LATE: Duration = Duration::from_secs(60);

    fn connect(server: &TcpServer) -> TcpStream {
        let stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(LATE)).unwrap();
        stream
    }

    fn said_back(stream: &mut TcpStream, bytes: &[u8]) -> Vec<u8> {
        let writer = stream.try_clone().unwrap();
        crate::echo::said_back(stream, writer, bytes)
    }

    #[test]
    fn one_client_after_the_other_is_served_and_a_second_one_beside_it_is_not() {
        let (rig, host) = rig();
        let server = TcpServer::serve(host, "127.0.0.1:0").unwrap();
        let bytes = many_bytes();
        for _ in 0..3 {
            assert!(said_back(&mut connect(&server), &bytes) == bytes);
        }
        for _ in 0..10 {
            assert_eq!(said_back(&mut connect(&server), b"at once"), b"at once");
        }
        let mut first = connect(&server);
        assert_eq!(said_back(&mut first, b"mine"), b"mine");
        assert_eq!(connect(&server).read(&mut [0; 8]).unwrap(), 0);
        assert_eq!(said_back(&mut first, b"still mine"), b"still mine");
        first.write_all(&[END]).unwrap();
        rig.join().unwrap();
    }

    #[test]
    fn an_address_in_use_is_an_error() {
        let (_link, host) = pipe(16);
        let server = TcpServer::serve(host, "127.0.0.1:0").unwrap();
        let (_link, host) = pipe(16);
        let error = TcpServer::serve(host, server.address()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AddrInUse);
    }
}
