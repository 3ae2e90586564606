//! Without `--tcp` the rig is served on a pty.

use massline_virtual::pipe::HostEnd;
use massline_virtual::pty::PtyServer;

use super::ServedPort;
use crate::{Error, Result};

/// Serves the rig behind `link`.
pub fn serve(link: HostEnd) -> Result<ServedPort> {
    let server = PtyServer::serve(link)
        .map_err(|e| Error::internal("no_pty", format!("the system gives no pty: {e}")))?;
    Ok(ServedPort {
        is_open_to_others: false,
        port: server.path().display().to_string(),
        _server: Box::new(server),
    })
}
