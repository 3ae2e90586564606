//! The JSON output of calibration commands.

use serde_json::Value;

use crate::program::success;

/// Runs `calibrate` on the simulated block with its flash in this file.
fn calibrate(arguments: &[&str], flash: &str) -> Value {
    let block_rig = ["--rig", "virtual", "--seed", "7", "--flash", flash];
    success(&[&["calibrate"], arguments, &block_rig].concat())
}

#[test]
fn the_json_of_a_block_test_has_the_rc_cutoffs_that_the_rig_stores() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash.bin").display().to_string();
    let value = calibrate(&["block", "--mass", "2.0"], &flash);
    let kept = calibrate(&["show"], &flash);
    let cutoffs = value["block"]["rc_cutoffs"].as_array().unwrap();
    assert_eq!(cutoffs.len(), 9);
    let mut changed = 0;
    for (k, cutoff) in cutoffs.iter().enumerate() {
        let (sensor, axis) = (k / 3, k % 3);
        assert_eq!(cutoff["sensor"], sensor + 1);
        assert_eq!(cutoff["axis"], ["x", "y", "z"][axis]);
        assert!(cutoff["reason"].is_null(), "{cutoff}");
        let number = |name: &str| cutoff[name].as_f64().unwrap();
        let [found, sigma, before] = ["cutoff_hz", "sigma_hz", "before_hz"].map(number);
        let is_changed = (found - before).abs() > 3.0 * sigma;
        changed += usize::from(is_changed);
        assert_eq!(cutoff["verdict"], if is_changed { "changed" } else { "kept" });
        // The rig stores it in single precision.
        let stored = kept["sensors"][sensor]["rc_cutoff_hz"][axis].as_f64().unwrap();
        let expected = if is_changed { found } else { before };
        assert!((stored / expected - 1.0).abs() < 1e-6, "{stored} {cutoff}");
    }
    // Cutoffs with a tolerance of 2 % (1 σ) are found to 0.25 %: most of nine are more than three of
    // these sigmas off.
    assert!(changed > 4, "{cutoffs:?}");
    let hammer = kept["hammer"]["rc_cutoff_hz"].as_f64().unwrap();
    assert!((hammer - 497.359).abs() < 1e-3, "{hammer}");
}
