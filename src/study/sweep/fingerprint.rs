//! Fingerprint that identifies the study of stored results.

use super::Study;

impl Study {
    /// FNV-1a hash of everything that determines the results: text, base scene, model, checks and program version. 16
    /// hexadecimal digits. It protects against mistakes, not against tampering.
    pub fn fingerprint(&self) -> String {
        let checked = if self.checked { "checked" } else { "" };
        let inputs = [env!("CARGO_PKG_VERSION"), self.model.name(), self.source.as_str(), self.base.as_str(), checked];
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for input in inputs {
            // The length is hashed first, so that the boundary between two texts is unique.
            for byte in (input.len() as u64).to_le_bytes().iter().chain(input.as_bytes()) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        format!("{hash:016x}")
    }
}
