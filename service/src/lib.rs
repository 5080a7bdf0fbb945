//! overcoat for many files: `overcoat batch` and `overcoat serve`; `overcoat mcp` for programs that use tools.
//!
//! Models are parsed in worker processes alone, which have no rights, limits of memory and time, and an end that nobody else
//! notices. This process hands them bytes and takes pictures.

// Options are documented by their help, which is no markup.
#[allow(missing_docs, rustdoc::bare_urls, rustdoc::broken_intra_doc_links)]
pub mod batch;
pub mod common;
pub mod files;
pub mod key;
// As are those of the tools.
#[allow(missing_docs, rustdoc::bare_urls, rustdoc::broken_intra_doc_links)]
pub mod mcp;
pub mod place;
pub mod pool;
// As are those of the service.
#[allow(missing_docs, rustdoc::bare_urls, rustdoc::broken_intra_doc_links)]
pub mod serve;
mod status_page;
