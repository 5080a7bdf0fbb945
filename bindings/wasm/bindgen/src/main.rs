//! Makes of a module that was compiled with wasm-bindgen's attributes the module and the JavaScript that load it.
//!
//! Usage: overcoat-bindgen INPUT.wasm OUTPUT-FOLDER

use std::path::Path;
use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, folder] = arguments.as_slice() else {
        eprintln!("usage: overcoat-bindgen INPUT.wasm OUTPUT-FOLDER");
        return ExitCode::from(2);
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(Path::new(input)).out_name("overcoat").typescript(false);
    // Nobody downloads the names of functions.
    bindgen.remove_name_section(true).remove_producers_section(true);
    // After a trap, a new instance takes the place of the old.
    bindgen.reset_state_function(true);
    match bindgen.web(true).and_then(|bindgen| bindgen.generate(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{input}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
