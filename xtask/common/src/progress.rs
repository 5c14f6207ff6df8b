//! The progress bar.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar for `steps` steps, with the time and room for a message.
pub fn progress_bar(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {elapsed}  {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps as u64).with_style(style)
}
