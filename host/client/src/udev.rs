//! The rules by which Linux lets the logged-in user open a device.

/// What to do so that a device of this subsystem and USB identity may be opened; `attribute` is `ATTR` for the device
/// itself and `ATTRS` for what hangs on it. ModemManager, which writes to every new serial port, is kept from it.
pub fn advice(subsystem: &str, attribute: &str, usb: Option<(u16, u16)>) -> String {
    let usb = usb.map_or_else(String::new, |(vendor, product)| {
        format!(
            ", {attribute}{{idVendor}}==\"{vendor:04x}\", {attribute}{{idProduct}}==\"{product:04x}\""
        )
    });
    format!(
        "put this line into /etc/udev/rules.d/70-massline.rules, run `sudo udevadm control --reload`, and plug the \
         board in again:\nSUBSYSTEM==\"{subsystem}\"{usb}, TAG+=\"uaccess\", ENV{{ID_MM_DEVICE_IGNORE}}=\"1\""
    )
}
