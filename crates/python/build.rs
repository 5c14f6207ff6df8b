//! How the linker makes an extension module, which matters on macOS.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
