//! The part of the vector table after the exceptions of the core.

use super::{link, time};

/// One of the machine's interrupts, in the order of its numbers.
type Vector = unsafe extern "C" fn();

unsafe extern "C" {
    fn DefaultHandler();
}

// The linker script puts this section after the exceptions.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [Vector; 32] = {
    let mut table: [Vector; 32] = [DefaultHandler; 32];
    table[0] = on_uart0_rx;
    table[1] = on_uart0_tx;
    table[8] = on_timer0;
    table[9] = on_timer1;
    table
};

extern "C" fn on_uart0_rx() {
    link::on_receive();
}

extern "C" fn on_uart0_tx() {
    link::on_sent();
}

extern "C" fn on_timer0() {
    time::on_lap();
}

extern "C" fn on_timer1() {
    time::on_alarm();
}
