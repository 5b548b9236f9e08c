//! What is found in folders as programs leave them, and what is written of it.

mod folder;
mod found;
mod layouts;
mod places;
