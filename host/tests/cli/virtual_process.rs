//! A virtual rig in its own process.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// `massline virtual`, on the ideal bench unless another one is named; the process ends when this value is dropped.
pub struct VirtualProcess {
    /// The process; what is typed goes to its input.
    pub process: Child,
    /// Path of the pty that it serves.
    pub port: String,
}

impl VirtualProcess {
    /// Starts it with additional arguments.
    pub fn start(arguments: &[&str]) -> Self {
        Self::on_bench("ideal", arguments)
    }

    /// Starts it on another bench.
    pub fn on_bench(bench: &str, arguments: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_massline"))
            .args(["virtual", "--bench", bench])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the virtual rig starts");
        let mut port = String::new();
        let stdout = process.stdout.take().expect("its output is piped");
        BufReader::new(stdout).read_line(&mut port).expect("it prints its port");
        Self { process, port: port.trim().to_owned() }
    }
}

impl Drop for VirtualProcess {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
