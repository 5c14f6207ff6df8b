//! `cargo xtask casts`: checks that no library cuts off an integer with `as` unnoticed.
//!
//! A cast with `as` to an integer of 32 bits or fewer is an error, unless the function or the `let` around it says
//! why it is right: `#[expect(clippy::cast_possible_truncation, reason = "...")]`, or `allow`, or another lint of casts.
//! `mesh_core::as_u32` casts indices and counts of elements, and `try_from` casts numbers from files, records and
//! options. Test code is not checked.

use std::fs;
use std::path::{Path, PathBuf};

use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};

use xtask_common::Failure;

use crate::files::{entries, is_for_tests, rust_files};

/// The packages to check.
#[derive(Debug, clap::Args)]
pub(crate) struct Casts {
    /// The folders of the packages; all of the workspace in `crates` by default
    #[arg(value_name = "DIR")]
    packages: Vec<PathBuf>,
}

const NARROW: [&str; 6] = ["u8", "u16", "u32", "i8", "i16", "i32"];

pub(crate) fn run(options: &Casts) -> Result<(), Failure> {
    let mut folders = options.packages.clone();
    if folders.is_empty() {
        folders = entries(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates"))?;
        folders.sort();
    }
    let (mut files, mut casts) = (0, 0);
    for folder in &folders {
        for file in rust_files(folder)? {
            // Other folders of a package are tests, examples and benchmarks.
            if !file.components().any(|part| part.as_os_str() == "src") {
                continue;
            }
            files += 1;
            let text = fs::read_to_string(&file).map_err(Failure::reading(&file))?;
            for (function, kind) in casts_of(&text).map_err(Failure::reading(&file))? {
                casts += 1;
                println!("{}: {function} casts to {kind} with `as`", file.display());
            }
        }
    }
    println!("{files} files, {casts} casts without a reason");
    if casts == 0 { Ok(()) } else { Err(failure(casts)) }
}

fn failure(casts: usize) -> Failure {
    Failure::Check(format!(
        "{casts} casts may cut off a number; use `mesh_core::as_u32`, `from`, `try_from`, or say why the number fits \
         in an `expect` of clippy's lint on the function"
    ))
}

/// The function and the type of every cast to a narrow integer without a reason.
fn casts_of(text: &str) -> Result<Vec<(String, String)>, syn::Error> {
    let mut reader = Reader { function: "the file".into(), ..Reader::default() };
    reader.visit_file(&syn::parse_file(text)?);
    Ok(reader.found)
}

#[derive(Default)]
struct Reader {
    function: String,
    /// The number of reasons around the current expression.
    reasons: usize,
    found: Vec<(String, String)>,
}

impl Reader {
    /// Visits a part with these attributes.
    fn within(&mut self, attributes: &[syn::Attribute], visit: impl FnOnce(&mut Self)) {
        let reasons = self.reasons;
        self.reasons += attributes.iter().filter(|attribute| is_reason(attribute)).count();
        visit(self);
        self.reasons = reasons;
    }

    fn within_function(&mut self, name: &syn::Ident, visit: impl FnOnce(&mut Self)) {
        let outer = core::mem::replace(&mut self.function, name.to_string());
        visit(self);
        self.function = outer;
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !item.attrs.iter().any(is_for_tests) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !item.attrs.iter().any(is_for_tests) {
            self.within(&item.attrs, |inner| {
                inner.within_function(&item.sig.ident, |inner| visit::visit_item_fn(inner, item));
            });
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !item.attrs.iter().any(is_for_tests) {
            self.within(&item.attrs, |inner| {
                inner.within_function(&item.sig.ident, |inner| {
                    visit::visit_impl_item_fn(inner, item);
                });
            });
        }
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.within(&item.attrs, |inner| visit::visit_item_const(inner, item));
    }

    fn visit_local(&mut self, item: &'ast syn::Local) {
        self.within(&item.attrs, |inner| visit::visit_local(inner, item));
    }

    fn visit_expr_cast(&mut self, cast: &'ast syn::ExprCast) {
        if let syn::Type::Path(path) = &*cast.ty
            && let Some(kind) = NARROW.iter().find(|kind| path.path.is_ident(kind))
            && self.reasons == 0
        {
            self.found.push((self.function.clone(), (*kind).to_owned()));
        }
        visit::visit_expr_cast(self, cast);
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        // The arguments of most macros are expressions; `vec![value; count]` has a semicolon between them.
        let commas = Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated;
        let semicolons = Punctuated::<syn::Expr, syn::Token![;]>::parse_terminated;
        let with_commas = item.parse_body_with(commas).map(|list| list.into_iter().collect());
        let arguments: Vec<syn::Expr> = with_commas
            .or_else(|_| item.parse_body_with(semicolons).map(|list| list.into_iter().collect()))
            .unwrap_or_default();
        for argument in &arguments {
            self.visit_expr(argument);
        }
    }
}

/// Whether an attribute expects or allows a lint of casts and has a reason.
fn is_reason(attribute: &syn::Attribute) -> bool {
    let (mut is_of_casts, mut has_reason) = (false, false);
    if attribute.path().is_ident("expect") || attribute.path().is_ident("allow") {
        let read = attribute.parse_nested_meta(|meta| {
            if meta.path.is_ident("reason") {
                meta.value()?.parse::<syn::LitStr>()?;
                has_reason = true;
            } else if let Some(lint) = meta.path.segments.last() {
                is_of_casts |= lint.ident.to_string().starts_with("cast_");
            }
            Ok(())
        });
        return read.is_ok() && is_of_casts && has_reason;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::casts_of;

    #[test]
    fn casts_without_a_reason_are_found() {
        let text = "fn f(n: usize) -> u32 { n as u32 } \
                    impl A { fn g(&self) { let x = vec![self.n as u8; 2]; } } \
                    fn h(n: u64) -> usize { n as usize }";
        let found = casts_of(text).unwrap();
        assert_eq!(found, [("f", "u32"), ("g", "u8")].map(|(f, t)| (f.into(), t.into())));
    }

    #[test]
    fn reasons_and_tests_are_passed_over() {
        let text = "#[expect(clippy::cast_possible_truncation, reason = \"it is a hash\")] \
                    fn f(n: usize) -> u32 { n as u32 } \
                    fn g(x: f64) { #[expect(clippy::cast_sign_loss, reason = \"above 0\")] let n = x as u32; } \
                    #[cfg(test)] mod tests { fn h(n: usize) -> u32 { n as u32 } }";
        assert!(casts_of(text).unwrap().is_empty());
        let without_reason = "#[expect(clippy::cast_sign_loss)] fn f(n: f64) -> u32 { n as u32 }";
        assert_eq!(casts_of(without_reason).unwrap().len(), 1);
    }
}
