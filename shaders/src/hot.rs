//! A thing made from shaders that is remade when their files change, and stays as it was when that fails.

use std::collections::HashMap;
use std::hash::Hash;

use crate::error::ShaderError;
use crate::library::ShaderLibrary;

/// Pipelines (a struct of [`Kernel`](crate::Kernel)s) with the generation of the shader library they come from.
pub struct Hot<T> {
    value: T,
    generation: u64,
    error: Option<ShaderError>,
}

impl<T> Hot<T> {
    pub fn new(
        library: &ShaderLibrary,
        make: impl FnOnce(&ShaderLibrary) -> Result<T, ShaderError>,
    ) -> Result<Self, ShaderError> {
        let generation = library.generation();
        Ok(Self { value: make(library)?, generation, error: None })
    }

    /// Make it again if a shader file has changed. A failure keeps the last good one and is told by [`Hot::error`].
    /// True where there is a new one: whatever was bound to the old one must be bound again.
    pub fn refresh(
        &mut self,
        library: &ShaderLibrary,
        make: impl FnOnce(&ShaderLibrary) -> Result<T, ShaderError>,
    ) -> bool {
        let generation = library.generation();
        if generation == self.generation {
            return false;
        }
        self.generation = generation;
        match make(library) {
            Ok(value) => {
                (self.value, self.error) = (value, None);
                true
            }
            Err(error) => {
                log::error!("{error}");
                self.error = Some(error);
                false
            }
        }
    }

    /// Have the one of a key: made where there is none yet, refreshed where there is. True where it is another than before.
    pub fn have<K: Clone + Eq + Hash>(
        made: &mut HashMap<K, Self>,
        library: &ShaderLibrary,
        key: &K,
        make: impl FnOnce(&ShaderLibrary) -> Result<T, ShaderError>,
    ) -> Result<bool, ShaderError> {
        if let Some(known) = made.get_mut(key) {
            return Ok(known.refresh(library, make));
        }
        made.insert(key.clone(), Self::new(library, make)?);
        Ok(true)
    }

    /// Why the last edit is not in use.
    pub fn error(&self) -> Option<&ShaderError> {
        self.error.as_ref()
    }
}

impl<T> std::ops::Deref for Hot<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.value
    }
}
