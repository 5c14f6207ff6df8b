//! x
mod render;
fn main() {}
