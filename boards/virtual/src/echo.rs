//! A rig that says back what it reads, for the tests of what carries its bytes.

use std::io::{Read, Write};
use std::thread;

use embedded_io_async::{Read as _, Write as _};
use massline_firmware::board::Link;

use crate::clock::Executor;
use crate::pipe::{HostEnd, RigRx, RigTx, pipe};

/// At this byte it ends.
pub(crate) const END: u8 = b'!';

/// Starts such a rig.
pub(crate) fn rig() -> (thread::JoinHandle<Option<()>>, HostEnd) {
    let (link, host) = pipe(4096);
    let (rx, tx) = link.split();
    (thread::spawn(move || Executor::default().run(echo(rx, tx))), host)
}

/// Echoes everything, across changes of client, until it reads the end mark.
async fn echo(mut rx: RigRx, mut tx: RigTx) {
    let mut buffer = [0; 300];
    loop {
        // An error means that a client has left.
        let Ok(count) = rx.read(&mut buffer).await else { continue };
        if buffer[..count].contains(&END) {
            return;
        }
        let _ = tx.write_all(&buffer[..count]).await;
    }
}

/// Every byte value but the end mark, and more of them than what carries them holds.
pub(crate) fn many_bytes() -> Vec<u8> {
    (0..20_000_u32).map(|i| (i * 5 / 2) as u8).filter(|&b| b != END).collect()
}

/// What comes back for these bytes.
pub(crate) fn said_back(
    reader: &mut (impl Read + ?Sized),
    mut writer: impl Write + Send,
    bytes: &[u8],
) -> Vec<u8> {
    let mut answer = vec![0; bytes.len()];
    thread::scope(|scope| {
        scope.spawn(move || writer.write_all(bytes).unwrap());
        reader.read_exact(&mut answer).unwrap();
    });
    answer
}
