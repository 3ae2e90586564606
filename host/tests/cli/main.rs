//! The program `massline` as a person or another program runs it: what it prints, and its exit codes.

mod program;
mod virtual_process;

#[cfg(unix)]
mod archive;
mod calibrate;
mod config;
mod demo;
mod documents;
mod edited_results;
mod export;
mod foreign_uff;
#[cfg(unix)]
mod full_disk;
#[cfg(target_os = "linux")]
mod full_screen;
mod hits;
mod layout;
#[cfg(target_os = "linux")]
mod memory;
#[cfg(target_os = "linux")]
mod on_terminal;
mod one_answer;
mod options;
mod other_recorders;
#[cfg(unix)]
mod pipes;
mod plot;
mod recorded_units;
#[cfg(target_os = "linux")]
mod recording;
mod replay;
mod report;
mod report_contents;
#[cfg(unix)]
mod rig;
mod rig_restarts;
mod schema;
mod shell;
mod simulate;
#[cfg(unix)]
mod strangers;
mod suspension;
mod suspension_rig;
mod suspension_words;
#[cfg(unix)]
mod tape_files;
mod tcp;
#[cfg(target_os = "linux")]
mod terminal;
#[cfg(target_os = "linux")]
mod tumble_test;
mod verdict;
mod wrong_input;
