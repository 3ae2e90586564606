//! Without `--tcp` the rig is served on a free TCP port of this computer, because the system has no ptys.

use massline_virtual::pipe::HostEnd;

use super::{ServedPort, serve_tcp};
use crate::Result;

/// Serves the rig behind `link`.
pub fn serve(link: HostEnd) -> Result<ServedPort> {
    serve_tcp(link, "127.0.0.1:0")
}
