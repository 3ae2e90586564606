//! The program `massline` as a person or another program runs it: what it prints, and its exit codes.

mod program;
mod virtual_process;

#[cfg(unix)]
mod archive;
mod calibrate;
mod demo;
mod export;
mod hits;
mod layout;
mod options;
mod recorded_units;
mod replay;
#[cfg(unix)]
mod rig;
mod shell;
mod simulate;
mod suspension;
#[cfg(unix)]
mod tape_files;
mod tcp;
mod wrong_input;
