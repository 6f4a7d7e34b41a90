//! Where long work leaves what is done, so that it can go on after an end at any moment, without knowing where that is.
//!
//! Work is cut into named stages. A stage that is loaded is not computed; one that was computed is saved. What is kept must be what was
//! computed, to the bit, so that work in one go and work in pieces end the same.
//!
//! A stage whose name begins with [`STATE`] depends on all that the scene says; any other on what factors and direct light depend on.

/// How the names of stages begin that are states of an iteration, for one scene alone.
pub const STATE: &str = "state-";

/// A keeper of finished stages. Calls come from any thread.
pub trait Vault: Sync {
    /// The bytes kept under this name, or nothing.
    fn load(&self, stage: &str) -> Option<Vec<u8>>;
    /// Keeps the bytes under this name in place of earlier ones. A vault that cannot keeps nothing.
    fn save(&self, stage: &str, bytes: &[u8]);
    /// False where saving is in vain: nobody need prepare bytes.
    fn keeps(&self) -> bool {
        true
    }
}

/// Nothing is kept.
pub struct NoVault;

impl Vault for NoVault {
    fn load(&self, _: &str) -> Option<Vec<u8>> {
        None
    }
    fn save(&self, _: &str, _: &[u8]) {}
    fn keeps(&self) -> bool {
        false
    }
}
