//! Serial ports: USB CDC-ACM, UARTs and ptys.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ErrorKind, SerialPort, SerialPortType};

use crate::error::ClientError;
use crate::transport::Transport;

/// Baud rate, used where the port is a UART; USB and ptys ignore it.
const BAUD: u32 = 921_600;
/// How long the rig may take to accept a frame.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// Environment variable that names the port when no argument does.
pub const PORT_VARIABLE: &str = "MASSLINE_PORT";

/// A rig behind a serial port or a pty.
pub struct SerialTransport {
    path: String,
    port: Option<Box<dyn SerialPort>>,
}

impl SerialTransport {
    /// Opens a port.
    ///
    /// # Errors
    /// [`ClientError::NoSuchPort`], [`ClientError::PortBusy`], [`ClientError::NotOpened`].
    pub fn open(path: impl Into<String>) -> Result<Self, ClientError> {
        let path = path.into();
        let port = open(&path).map_err(|e| named(&path, &e))?;
        Ok(Self { path, port: Some(port) })
    }

    fn lost(&mut self, error: io::Error) -> io::Error {
        self.port = None;
        error
    }
}

impl Transport for SerialTransport {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let port = self.port.as_mut().ok_or_else(closed)?;
        if let Err(e) = port.set_timeout(timeout) {
            return Err(self.lost(e.into()));
        }
        match port.read(buffer) {
            // A port that is readable but returns no bytes has been unplugged.
            Ok(0) => Err(self.lost(closed())),
            Ok(n) => Ok(n),
            Err(e) if waits(&e) => Ok(0),
            Err(e) => Err(self.lost(e)),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let deadline = Instant::now() + WRITE_TIMEOUT;
        let port = self.port.as_mut().ok_or_else(closed)?;
        if let Err(e) = port.set_timeout(Duration::from_millis(200)) {
            return Err(self.lost(e.into()));
        }
        let mut left = bytes;
        while !left.is_empty() {
            match port.write(left) {
                Ok(n) => left = left.get(n..).unwrap_or_default(),
                Err(e) if waits(&e) && Instant::now() < deadline => {}
                // The rig reads nothing, but the link still exists; the client will repeat the request.
                Err(e) if waits(&e) => return Ok(()),
                Err(e) => return Err(self.lost(e)),
            }
        }
        Ok(())
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.port = None;
        self.port = Some(open(&self.path)?);
        Ok(())
    }

    fn name(&self) -> &str {
        &self.path
    }
}

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortFacts {
    /// Its path.
    pub path: String,
    /// USB vendor and product ID, when it is a USB device.
    pub usb: Option<(u16, u16)>,
    /// Manufacturer, product and serial number, as far as the device reports them.
    pub description: String,
}

/// The serial ports that may be a rig: those of USB devices.
///
/// # Errors
/// When the system cannot list its ports.
pub fn list_ports() -> Result<Vec<PortFacts>, ClientError> {
    let ports = serialport::available_ports().map_err(|e| ClientError::NotOpened {
        port: "the list of serial ports".into(),
        reason: e.to_string(),
    })?;
    let usb = ports.into_iter().filter_map(|port| match port.port_type {
        SerialPortType::UsbPort(usb) => {
            let words = [usb.manufacturer, usb.product, usb.serial_number];
            Some(PortFacts {
                path: port.port_name,
                usb: Some((usb.vid, usb.pid)),
                description: words.into_iter().flatten().collect::<Vec<_>>().join(" "),
            })
        }
        _ => None,
    });
    let mut facts: Vec<_> = usb.collect();
    leave_out_dial_in(&mut facts);
    facts.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(facts)
}

/// macOS lists a port twice. Its dial-in file `/dev/tty.…` waits for a modem when it is opened; `/dev/cu.…` does not.
fn leave_out_dial_in(ports: &mut Vec<PortFacts>) {
    let call_out: Vec<String> = ports.iter().map(|port| port.path.clone()).collect();
    ports.retain(|port| match port.path.strip_prefix("/dev/tty.") {
        Some(name) => !call_out.contains(&format!("/dev/cu.{name}")),
        None => true,
    });
}

/// The port for a command: the argument, else `MASSLINE_PORT`, else the only USB serial port.
///
/// # Errors
/// When there is no port or more than one; the error lists them.
pub fn choose_port(argument: Option<&str>) -> massline_result::Result<String> {
    let variable = std::env::var(PORT_VARIABLE).ok().filter(|v| !v.is_empty());
    if let Some(path) = argument.map(str::to_owned).or(variable) {
        return Ok(path);
    }
    only_one(list_ports()?)
}

fn only_one(mut ports: Vec<PortFacts>) -> massline_result::Result<String> {
    match ports.len() {
        1 => Ok(ports.remove(0).path),
        0 => Err(massline_result::Error::device(
            "no_port",
            format!(
                "no rig is connected: this computer has no USB serial port; connect the rig, name \
                 another port with --port or {PORT_VARIABLE}, or start a simulated rig with \
                 `massline virtual`"
            ),
        )),
        _ => {
            let paths: Vec<_> = ports.iter().map(|p| p.path.as_str()).collect();
            Err(massline_result::Error::input(
                "several_ports",
                format!(
                    "several ports may be the rig: {}; choose one with --port",
                    paths.join(", ")
                ),
            ))
        }
    }
}

fn open(path: &str) -> serialport::Result<Box<dyn SerialPort>> {
    let mut port = serialport::new(path, BAUD).timeout(WRITE_TIMEOUT).open()?;
    // Signals to the rig that the host reads. A pty has no DTR line.
    let _ = port.write_data_terminal_ready(true);
    Ok(port)
}

fn named(path: &str, error: &serialport::Error) -> ClientError {
    let (port, reason) = (path.to_owned(), error.to_string());
    match error.kind {
        ErrorKind::Io(io::ErrorKind::NotFound) => ClientError::NoSuchPort { port },
        ErrorKind::NoDevice if exists(path) => ClientError::PortBusy { port, reason },
        ErrorKind::NoDevice => ClientError::NoSuchPort { port },
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => ClientError::Denied { port, reason },
        _ if reason.contains(NOT_A_TERMINAL) => ClientError::NoPort { port },
        _ => ClientError::NotOpened { port, reason },
    }
}

/// What the system says of a file that is not a terminal, as every serial port is.
const NOT_A_TERMINAL: &str = "Not a typewriter";

/// True for a path of the file system, and for a name that the system lists: Windows has no file `COM3`.
fn exists(path: &str) -> bool {
    let name = path.strip_prefix(r"\\.\").unwrap_or(path);
    let listed = || serialport::available_ports().unwrap_or_default();
    std::path::Path::new(path).exists()
        || listed().iter().any(|port| port.port_name.eq_ignore_ascii_case(name))
}

fn waits(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    )
}

fn closed() -> io::Error {
    io::Error::new(io::ErrorKind::NotConnected, "the port is gone")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(path: &str) -> PortFacts {
        PortFacts { path: path.into(), usb: Some((1, 2)), description: String::new() }
    }

    #[test]
    fn the_only_port_is_taken() {
        assert_eq!(only_one(vec![port("a")]).unwrap(), "a");
    }

    #[test]
    fn of_several_ports_none_is_guessed() {
        let error = only_one(vec![port("a"), port("b")]).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("a, b"));
    }

    #[test]
    fn a_port_that_macos_lists_twice_is_one() {
        let mut ports =
            ["/dev/cu.usbmodem1", "/dev/tty.usbmodem1", "/dev/ttyACM0"].map(port).into();
        leave_out_dial_in(&mut ports);
        assert_eq!(ports, ["/dev/cu.usbmodem1", "/dev/ttyACM0"].map(port));
    }

    #[test]
    fn no_port_is_a_device_failure() {
        assert_eq!(only_one(Vec::new()).unwrap_err().exit_code(), 4);
    }

    #[test]
    fn a_port_that_does_not_exist_is_named() {
        let error = SerialTransport::open("/dev/no-such-port").err().unwrap();
        assert_eq!(error, ClientError::NoSuchPort { port: "/dev/no-such-port".into() });
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_no_port_is_named() {
        for path in ["/dev/null", env!("CARGO_MANIFEST_DIR"), file!()] {
            let error = SerialTransport::open(path).err().unwrap();
            assert!(!error.to_string().contains("typewriter"), "{error}");
        }
        assert_eq!(SerialTransport::open("/dev/null").err().unwrap().code(), "no_port");
    }

    #[cfg(unix)]
    #[test]
    fn a_port_that_another_program_has_is_busy() {
        let (_master, slave) = serialport::TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        let _other = SerialTransport::open(path.clone()).unwrap();
        let error = SerialTransport::open(path).err().unwrap();
        assert_eq!(error.code(), "port_busy");
    }

    #[cfg(unix)]
    #[test]
    fn bytes_cross_a_pty_and_silence_is_no_error() {
        let (mut master, slave) = serialport::TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        drop(slave);
        let mut transport = SerialTransport::open(path).unwrap();
        transport.write_all(&[0, 3, 4, 13, 10, 17, 255]).unwrap();
        let mut got = [0; 7];
        master.set_timeout(Duration::from_secs(5)).unwrap();
        master.read_exact(&mut got).unwrap();
        assert_eq!(got, [0, 3, 4, 13, 10, 17, 255]);
        assert_eq!(transport.read(&mut got, Duration::from_millis(1)).unwrap(), 0);
    }
}
