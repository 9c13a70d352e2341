//! Whether results that are found on the disk are of this study.

use super::Study;

impl Study {
    /// Tells studies apart whose results differ: text, base scene, model, and the version of this program. 16 hexadecimal
    /// digits of an FNV-1a hash: it guards against slips, not against malice.
    pub fn fingerprint(&self) -> String {
        let checked = if self.checked { "checked" } else { "" };
        let parts = [env!("CARGO_PKG_VERSION"), self.model.name(), self.source.as_str(), self.base.as_str(), checked];
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for part in parts {
            // The length goes first, so that no text can run over into the next.
            for byte in (part.len() as u64).to_le_bytes().iter().chain(part.as_bytes()) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        format!("{hash:016x}")
    }
}
